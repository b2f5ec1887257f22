//! File maps that survive a file which shrinks.
//!
//! Reading a mapped page that the file no longer backs raises SIGBUS, which ends the process. Once a program has called
//! [`install`], such pages read as zeros instead and [`Map::is_broken`] says so. Installing is up to the program: signal
//! handlers belong to the whole process. Outside Linux nothing is installed, and maps are plain maps.

use std::fs::File;
use std::io;
use std::ops::Deref;

use memmap2::Mmap;

#[cfg(target_os = "linux")]
mod linux;
#[cfg(target_os = "linux")]
use linux::{Slot, install_handler};

#[cfg(not(target_os = "linux"))]
mod elsewhere {
    pub struct Slot;

    impl Slot {
        pub fn claim(_bytes: &[u8]) -> Option<Self> {
            None
        }

        pub fn is_broken(&self) -> bool {
            false
        }
    }

    pub fn install_handler() -> std::io::Result<()> {
        Ok(())
    }
}
#[cfg(not(target_os = "linux"))]
use elsewhere::{Slot, install_handler};

/// Installs the guard for the rest of the process' life; more calls change nothing. Faults that are none of a [`Map`] go to
/// the handler that was there before.
///
/// # Errors
/// When the system refuses the signal handler.
pub fn install() -> io::Result<()> {
    static DONE: std::sync::Mutex<bool> = std::sync::Mutex::new(false);
    let mut done = DONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if !*done {
        install_handler()?;
        *done = true;
    }
    Ok(())
}

/// A file mapped read-only.
pub struct Map {
    // Dropped in this order: the handler forgets the map before the memory is given back.
    slot: Option<Slot>,
    map: Mmap,
}

impl Map {
    /// Maps `file`, which must not be empty.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn new(file: &File) -> io::Result<Self> {
        // SAFETY: the map is only ever read as bytes, for which every bit pattern is valid; what another process writes to the
        // file may or may not be seen. A file that shrinks is what this crate is for.
        let map = unsafe { Mmap::map(file) }?;
        let slot = Slot::claim(&map);
        Ok(Self { slot, map })
    }

    /// Whether a page was read that the file no longer backs. Its bytes, and all behind it, are zeros.
    pub fn is_broken(&self) -> bool {
        self.slot.as_ref().is_some_and(Slot::is_broken)
    }
}

impl Deref for Map {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.map
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn what_is_gone_reads_as_zeros_and_is_said() {
        install().expect("installed");
        install().expect("once more is harmless");
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(&[7; 40_000]).expect("written");
        let (whole, other) = (Map::new(&file).expect("mapped"), Map::new(&file).expect("mapped"));
        assert_eq!((whole[39_999], whole.is_broken()), (7, false));
        file.set_len(5000).expect("shortened");
        assert_eq!(whole[4999], 7);
        assert_eq!((whole[39_999], whole.is_broken()), (0, true));
        assert!(!other.is_broken(), "nobody has looked there yet");
        assert_eq!(other.iter().filter(|byte| **byte == 7).count(), 5000);
        assert!(other.is_broken());
    }

    #[test]
    fn slots_are_used_again() {
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(&[1; 100]).expect("written");
        for _ in 0..10_000 {
            assert!(Map::new(&file).expect("mapped").slot.is_some());
        }
    }
}
