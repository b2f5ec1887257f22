//! The signal handler and the list of maps it looks at. Everything the handler touches is atomic; all it calls is `mmap` and
//! `sigaction`, which are allowed there.

use std::io;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Maps guarded at the same time; more are plain maps.
const SLOTS: usize = 4096;

/// Start of an entry that is being filled in; no map lies there.
const CLAIMED: usize = 1;

struct Entry {
    /// Address; 0 for a free entry.
    start: AtomicUsize,
    end: AtomicUsize,
    broken: AtomicBool,
}

static ENTRIES: [Entry; SLOTS] = [const {
    Entry { start: AtomicUsize::new(0), end: AtomicUsize::new(0), broken: AtomicBool::new(false) }
}; SLOTS];

static PREVIOUS: OnceLock<libc::sigaction> = OnceLock::new();
static PAGE: AtomicUsize = AtomicUsize::new(4096);

/// An entry of the list, freed when dropped.
pub(super) struct Slot(usize);

impl Slot {
    /// Enters `bytes`, a map, which must stay mapped while the slot lives; `None` when the list is full.
    pub fn claim(bytes: &[u8]) -> Option<Self> {
        let free = |entry: &Entry| {
            entry.start.compare_exchange(0, CLAIMED, Ordering::Acquire, Ordering::Relaxed).is_ok()
        };
        let index = ENTRIES.iter().position(free)?;
        let (entry, start) = (&ENTRIES[index], bytes.as_ptr().addr());
        entry.broken.store(false, Ordering::Relaxed);
        entry.end.store(start + bytes.len(), Ordering::Relaxed);
        entry.start.store(start, Ordering::Release);
        Some(Self(index))
    }

    pub fn is_broken(&self) -> bool {
        ENTRIES[self.0].broken.load(Ordering::Acquire)
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        ENTRIES[self.0].start.store(0, Ordering::Release);
    }
}

pub(super) fn install_handler() -> io::Result<()> {
    // SAFETY: `sysconf` has no preconditions; the structures are plain data for which zeros are valid, filled in before use;
    // the handler has the signature that SA_SIGINFO asks for.
    unsafe {
        let page = usize::try_from(libc::sysconf(libc::_SC_PAGESIZE)).unwrap_or(4096);
        PAGE.store(page.max(1), Ordering::Relaxed);
        let mut previous: libc::sigaction = std::mem::zeroed();
        if libc::sigaction(libc::SIGBUS, std::ptr::null(), &mut previous) != 0 {
            return Err(io::Error::last_os_error());
        }
        // Set before the handler can run.
        let _ = PREVIOUS.set(previous);
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = handler as extern "C" fn(_, _, _) as usize;
        action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
        if libc::sigaction(libc::SIGBUS, &action, std::ptr::null_mut()) != 0 {
            return Err(io::Error::last_os_error());
        }
    }
    Ok(())
}

extern "C" fn handler(_signal: libc::c_int, info: *mut libc::siginfo_t, _context: *mut libc::c_void) {
    // SAFETY: the kernel passes a valid `siginfo_t` for SA_SIGINFO, and SIGBUS fills in the address.
    let address = unsafe { (*info).si_addr() }.addr();
    if !patch(address)
        && let Some(previous) = PREVIOUS.get()
    {
        // Not ours: the instruction faults again and meets the handler before us.
        // SAFETY: `previous` came from `sigaction`.
        unsafe { libc::sigaction(libc::SIGBUS, previous, std::ptr::null_mut()) };
    }
}

/// Puts zeros where `address` lies in a guarded map, up to its end; `false` when it lies in none.
fn patch(address: usize) -> bool {
    let covers = |entry: &&Entry| {
        let start = entry.start.load(Ordering::Acquire);
        start > CLAIMED && (start..entry.end.load(Ordering::Relaxed)).contains(&address)
    };
    let Some(entry) = ENTRIES.iter().find(covers) else { return false };
    let first = address - address % PAGE.load(Ordering::Relaxed);
    let length = entry.end.load(Ordering::Relaxed) - first;
    // SAFETY: the range is inside a map that its slot keeps alive, and only ever read; the new pages are as readable.
    // `errno` belongs to the interrupted code.
    unsafe {
        let errno = *libc::__errno_location();
        let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_FIXED;
        let place = std::ptr::without_provenance_mut(first);
        let patched = libc::mmap(place, length, libc::PROT_READ, flags, -1, 0) != libc::MAP_FAILED;
        *libc::__errno_location() = errno;
        entry.broken.store(patched, Ordering::Release);
        patched
    }
}
