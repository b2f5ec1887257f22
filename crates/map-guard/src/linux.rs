//! The signal handler and the list of maps it looks at. Everything the handler touches is atomic; all it calls is `mmap` and
//! `sigaction`, which are allowed there.

use std::io;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering, fence};

/// Maps guarded at the same time; more are plain maps.
const SLOTS: usize = 4096;

/// Start of an entry that is being filled in; no map lies there.
const CLAIMED: usize = 1;

struct Entry {
    /// How often it was claimed: tells a reader that `start` and `end` are not of the same map.
    claims: AtomicUsize,
    /// Address; 0 for a free entry.
    start: AtomicUsize,
    end: AtomicUsize,
    broken: AtomicBool,
}

impl Entry {
    const fn new() -> Self {
        Self {
            claims: AtomicUsize::new(0),
            start: AtomicUsize::new(0),
            end: AtomicUsize::new(0),
            broken: AtomicBool::new(false),
        }
    }

    /// Whether the entry was free; it now is that of `bytes`.
    fn claim(&self, bytes: &[u8]) -> bool {
        let claimed = self.start.compare_exchange(0, CLAIMED, Ordering::Acquire, Ordering::Relaxed).is_ok();
        if claimed {
            let start = bytes.as_ptr().addr();
            self.claims.fetch_add(1, Ordering::AcqRel);
            fence(Ordering::Release);
            self.broken.store(false, Ordering::Relaxed);
            self.end.store(start + bytes.len(), Ordering::Relaxed);
            self.start.store(start, Ordering::Release);
        }
        claimed
    }

    fn free(&self) {
        self.start.store(0, Ordering::Release);
    }

    /// End of the map when `address` lies in it.
    fn end_around(&self, address: usize) -> Option<usize> {
        let claims = self.claims.load(Ordering::Acquire);
        let (start, end) = (self.start.load(Ordering::Acquire), self.end.load(Ordering::Relaxed));
        fence(Ordering::Acquire);
        // The map of a fault is being read and keeps its entry; one that changes meanwhile is another's.
        let is_one_map = self.claims.load(Ordering::Relaxed) == claims;
        (is_one_map && start > CLAIMED && (start..end).contains(&address)).then_some(end)
    }
}

static ENTRIES: [Entry; SLOTS] = [const { Entry::new() }; SLOTS];

static PREVIOUS: OnceLock<libc::sigaction> = OnceLock::new();
static PAGE: AtomicUsize = AtomicUsize::new(4096);

/// An entry of the list, freed when dropped.
pub(super) struct Slot(usize);

impl Slot {
    /// Enters `bytes`, a map, which must stay mapped while the slot lives; `None` when the list is full.
    pub fn claim(bytes: &[u8]) -> Option<Self> {
        ENTRIES.iter().position(|entry| entry.claim(bytes)).map(Self)
    }

    pub fn is_broken(&self) -> bool {
        ENTRIES[self.0].broken.load(Ordering::Acquire)
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        ENTRIES[self.0].free();
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
    let covering = |entry: &'static Entry| Some((entry, entry.end_around(address)?));
    let Some((entry, end)) = ENTRIES.iter().find_map(covering) else { return false };
    let first = address - address % PAGE.load(Ordering::Relaxed);
    // Said before there are zeros: another thread may read them at once and ask, having met no fault of its own.
    entry.broken.store(true, Ordering::Release);
    // SAFETY: the range is inside a map that its slot keeps alive, and only ever read; the new pages are as readable.
    // `errno` belongs to the interrupted code.
    unsafe {
        let errno = *libc::__errno_location();
        let flags = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS | libc::MAP_FIXED;
        let place = std::ptr::without_provenance_mut(first);
        let patched = libc::mmap(place, end - first, libc::PROT_READ, flags, -1, 0) != libc::MAP_FAILED;
        *libc::__errno_location() = errno;
        patched
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries go over from maps below an address to maps above it while it is looked up: it lies in none of them.
    #[test]
    fn a_start_and_an_end_of_different_maps_are_no_map() {
        let memory = vec![0_u8; 3 << 20];
        let (below, rest) = memory.split_at(1 << 20);
        let (between, above) = rest.split_at(1 << 20);
        let address = between.as_ptr().addr();
        let (entry, done) = (Entry::new(), AtomicBool::new(false));
        std::thread::scope(|threads| {
            threads.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    for bytes in [below, above] {
                        assert!(entry.claim(bytes));
                        entry.free();
                    }
                }
            });
            // More readers than cores: that one is stopped between its two loads is what it takes.
            let read = || (0..60_000_000).find_map(|_| entry.end_around(address));
            let readers: Vec<_> = (0..6).map(|_| threads.spawn(read)).collect();
            let found: Vec<_> = readers.into_iter().filter_map(|r| r.join().expect("no panic")).collect();
            done.store(true, Ordering::Relaxed);
            assert_eq!(found, []);
        });
    }
}
