//! Packed files: `.bgeo`, as SPlisHSPlasH and partio write it. They are unpacked into memory, since nothing in them can be found
//! otherwise.

use std::io::Read;

use flate2::bufread::MultiGzDecoder;

use crate::Error;
use crate::format::bgeo;
use crate::forward::Forward;
use crate::input_file::InputFile;

/// Bytes that any file may unpack to.
const ALWAYS: usize = 256 << 20;

/// How many times its size a larger one may unpack to. Particles at rest on a lattice, with attributes that are zero, come to 30;
/// the format allows 1032, which only a trap comes near.
const RATIO: usize = 100;

/// The `.bgeo` file that is packed in `file`, under its name. VTK packs the arrays in its files, and reads none that is packed as a
/// whole; neither do we.
pub(super) fn unpack(file: &InputFile) -> Result<InputFile, Error> {
    let limit = file.len().saturating_mul(RATIO).max(ALWAYS);
    let mut packed = Forward::new(file, 0);
    let mut bytes = Vec::new();
    let mut unpacked = MultiGzDecoder::new(&mut packed).take(bgeo::MAGIC.len() as u64);
    let mut outcome = unpacked.read_to_end(&mut bytes);
    let is_bgeo = bytes == bgeo::MAGIC;
    if is_bgeo {
        // One more shows that there is more than that.
        unpacked.set_limit(limit as u64 + 1);
        outcome = unpacked.read_to_end(&mut bytes);
    }
    drop(unpacked);
    if let Some(failure) = packed.take_failure() {
        return Err(failure);
    }
    if !is_bgeo {
        let message = "gzip data of something else than .bgeo; unpack it with gunzip first";
        return Err(Error::unsupported(file.path(), message));
    }
    if let Err(error) = outcome {
        let place = format_args!("gzip data, after {} bytes of content", bytes.len());
        return Err(Error::malformed(file.path(), place, format_args!("{error}; it is damaged or cut off")));
    }
    if bytes.len() > limit {
        let message =
            format_args!("it unpacks to more than {RATIO} times its size; unpack it with gunzip first");
        return Err(Error::unsupported(file.path(), message));
    }
    bytes.shrink_to_fit();
    Ok(file.with_content(bytes))
}
