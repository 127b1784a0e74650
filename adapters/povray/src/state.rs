//! POV-Ray 3.7's render state file (`+C`): finished blocks as single-precision
//! pixels, before any encoding.
//!
//! Read, it gives the pixels of a render as POV-Ray holds them. Written, it
//! tells POV-Ray which blocks are done already, so that any set of blocks can
//! be rendered in one call.
//!
//! Layout: a header of 512 bytes; then records, each `POVRAYMS`, a version, a
//! size and that many bytes of an object: a count of attributes, each a key, a
//! type, a length and its value, all in big-endian order. The attributes that
//! matter: `PiId` (the block's number, row by row), `Left`, `Top `, `Righ`,
//! `Bott` (its rectangle, inclusive), `PBlo` (five numbers a pixel: red, green,
//! blue, filter, transmit; linear, premultiplied).

use std::io::{Read, Seek, SeekFrom, Write};

use decor_api::{Blocks, Size, Window};

/// The side of a block, in pixels, where nothing else is said.
pub const BLOCK: u32 = 32;

/// The side of the smallest blocks that POV-Ray draws.
pub const LEAST: u32 = 4;

const SIGNATURE: &[u8] = b"POV-Ray Render State File\0\0\0";
const VERSION: &[u8] = b"0001";
const HEADER_BYTES: usize = 512;
const RECORD_SIGNATURE: &[u8] = b"POVRAYMS";
const RECORD_VERSION: u32 = 0x370;
const RECORD_HEADER_BYTES: usize = 20;
/// Numbers a pixel.
const CHANNELS: usize = 5;

/// Why a state file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StateError {
    /// It does not begin as one of 3.7.
    #[error("it is not a render state file of POV-Ray 3.7")]
    Header,
    /// It ends, or goes astray, inside a record.
    #[error("its record at byte {0} is damaged")]
    Record(usize),
    /// It cannot be read.
    #[error("it cannot be read: {0}")]
    Unreadable(std::io::ErrorKind),
    /// Blocks are missing: the render did not finish.
    #[error("{missing} of {wanted} pixels are missing")]
    Incomplete {
        /// Pixels that no block holds.
        missing: usize,
        /// Pixels of the window.
        wanted: usize,
    },
}

/// A state file without any block: everything is to be rendered.
pub fn empty() -> Vec<u8> {
    let mut file = Vec::with_capacity(HEADER_BYTES);
    file.extend_from_slice(SIGNATURE);
    file.extend_from_slice(VERSION);
    file.resize(HEADER_BYTES, 0);
    file
}

/// A state file for a picture of `size` in which every block but `wanted` is
/// called done. The picture is to be rendered in blocks of that side (`+BS`).
pub fn masked(size: Size, wanted: &Blocks) -> Vec<u8> {
    let mut file = Vec::new();
    // A vector takes all that is written.
    let _ = write_masked(&mut file, size, wanted);
    file
}

/// The same, written: of small blocks there are so many that a few such files
/// at once would be more than all else that is held.
///
/// # Errors
/// What the writer says.
pub fn write_masked(mut to: impl Write, size: Size, wanted: &Blocks) -> std::io::Result<()> {
    to.write_all(&empty())?;
    let blocks = blocks_of(size, wanted.side);
    let mut wanted = wanted.numbers.iter().copied().peekable();
    let mut done = DoneRecord::new();
    for block in 0..blocks {
        if wanted.next_if_eq(&block).is_none() {
            to.write_all(done.of(block))?;
        }
    }
    Ok(())
}

/// How many blocks of that side a picture has.
fn blocks_of(size: Size, side: u32) -> u32 {
    size.width.div_ceil(side) * size.height.div_ceil(side)
}

/// How many records [`write_masked`] writes.
fn others(size: Size, wanted: &Blocks) -> usize {
    (blocks_of(size, wanted.side) as usize).saturating_sub(wanted.numbers.len())
}

/// A record that calls a block done, and draws nothing.
///
/// POV-Ray asks any message of the file for the number of a block that it need not
/// render, and shows what it has of a picture only where it knows the message's name.
/// Without rectangle and pixels a record takes it a third of the time.
struct DoneRecord {
    bytes: Vec<u8>,
    /// Where the block's number is.
    place: usize,
}

impl DoneRecord {
    fn new() -> Self {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(RECORD_SIGNATURE);
        bytes.extend_from_slice(&RECORD_VERSION.to_be_bytes());
        bytes.extend_from_slice(&[0; 4]);
        bytes.extend_from_slice(b"RAWSOBJE");
        bytes.extend_from_slice(&3_u32.to_be_bytes());
        let mut attribute = |key: &[u8; 4], kind: &[u8; 4], value: &[u8; 4]| {
            bytes.extend_from_slice(key);
            bytes.extend_from_slice(kind);
            bytes.extend_from_slice(&4_u32.to_be_bytes());
            bytes.extend_from_slice(value);
            bytes.len() - value.len()
        };
        attribute(b"OCLA", b"TYPE", b"PixD");
        // No message of POV-Ray has this name.
        attribute(b"MIDE", b"TYPE", b"Done");
        let place = attribute(b"PiId", b"INT4", &[0; 4]);
        let size = (bytes.len() - RECORD_HEADER_BYTES) as u32;
        bytes[12..16].copy_from_slice(&size.to_be_bytes());
        Self { bytes, place }
    }

    /// For a block of that number.
    fn of(&mut self, id: u32) -> &[u8] {
        self.bytes[self.place..self.place + 4].copy_from_slice(&id.to_be_bytes());
        &self.bytes
    }
}

/// A block of a state file; its pixels are still in the file's bytes.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// Its number.
    pub id: u32,
    /// Its rectangle in the rendered picture.
    pub window: Window,
    /// Five big-endian numbers a pixel, row by row.
    pixels: &'a [u8],
    /// The record as it stands in the file.
    record: &'a [u8],
}

impl<'a> Block<'a> {
    /// Its record, for another file ([`with_records`]).
    pub fn record(&self) -> &'a [u8] {
        self.record
    }

    /// Does it show the very same as another one?
    pub fn is_same(&self, other: &Block<'_>) -> bool {
        self.window == other.window && self.pixels == other.pixels
    }

    /// Its pixels row by row: red, green, blue, filter, transmit.
    pub fn numbers(&self) -> impl Iterator<Item = [f32; CHANNELS]> + use<'a> {
        self.pixels.chunks_exact(4 * CHANNELS).map(numbers)
    }
}

/// A state file that holds these records ([`Block::record`]), those of the
/// blocks that are done. Ascending by block, each once.
pub fn with_records<'a>(records: impl IntoIterator<Item = &'a [u8]>) -> Vec<u8> {
    let mut file = empty();
    for record in records {
        file.extend_from_slice(record);
    }
    file
}

/// All whole blocks of a state file, in the order in which they were finished.
///
/// # Errors
/// Where the file is not of this format. A record that is cut off at the end is
/// left out, as POV-Ray does.
pub fn blocks(file: &[u8]) -> Result<Vec<Block<'_>>, StateError> {
    is_known(file)?;
    let mut found = Vec::new();
    let mut at = HEADER_BYTES;
    while let Some(head) = file.get(at..at + RECORD_HEADER_BYTES) {
        let size = record_size(head, at)?;
        let body = at + RECORD_HEADER_BYTES;
        let Some(record) = body.checked_add(size).and_then(|end| file.get(body..end)) else {
            break;
        };
        if let Some(mut block) = block(record).ok_or(StateError::Record(at))? {
            block.record = &file[at..body + size];
            found.push(block);
        }
        at = body + size;
    }
    Ok(found)
}

/// Does a file begin as one of 3.7?
fn is_known(file: &[u8]) -> Result<(), StateError> {
    let header = file.get(..HEADER_BYTES).ok_or(StateError::Header)?;
    if header.starts_with(SIGNATURE) && &header[SIGNATURE.len()..][..4] == VERSION {
        Ok(())
    } else {
        Err(StateError::Header)
    }
}

/// How many bytes follow the head of the record at byte `at`.
fn record_size(head: &[u8], at: usize) -> Result<usize, StateError> {
    if !head.starts_with(RECORD_SIGNATURE) || be_u32(head, 8) != Some(RECORD_VERSION) {
        return Err(StateError::Record(at));
    }
    Ok(be_u32(head, 12).ok_or(StateError::Record(at))? as usize)
}

/// The block in a record, if it is about one. `None`: the record is damaged.
fn block(record: &[u8]) -> Option<Option<Block<'_>>> {
    let mut at = 8;
    let (mut id, mut rectangle, mut pixels) = (None, [None; 4], None);
    for _ in 0..be_u32(record, 4)? {
        let key = record.get(at..at + 4)?;
        let kind = record.get(at + 4..at + 8)?;
        let length = be_u32(record, at + 8)? as usize;
        let bytes = match kind {
            // The length of a vector is a count of numbers.
            b"VFL4" => length.checked_mul(4)?,
            _ => length,
        };
        let from = at + 12;
        let value = record.get(from..from.checked_add(bytes)?)?;
        match key {
            b"PiId" => id = be_u32(value, 0),
            b"Left" => rectangle[0] = be_u32(value, 0),
            b"Top " => rectangle[1] = be_u32(value, 0),
            b"Righ" => rectangle[2] = be_u32(value, 0),
            b"Bott" => rectangle[3] = be_u32(value, 0),
            b"PBlo" => pixels = Some(value),
            _ => {}
        }
        at = from + bytes;
    }
    let ([Some(left), Some(top), Some(right), Some(bottom)], Some(id), Some(pixels)) =
        (rectangle, id, pixels)
    else {
        return Some(None);
    };
    let window = Window {
        x: left,
        y: top,
        width: right.checked_sub(left)?.checked_add(1)?,
        height: bottom.checked_sub(top)?.checked_add(1)?,
    };
    if window.pixels().checked_mul(4 * CHANNELS)? != pixels.len() {
        return None;
    }
    Some(Some(Block {
        id,
        window,
        pixels,
        record: &[],
    }))
}

fn be_u32(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at + 4)?;
    Some(u32::from_be_bytes(four.try_into().ok()?))
}

/// Which pixels of a render have to be there.
#[derive(Clone, Copy, Debug)]
pub enum Wanted<'a> {
    /// All of them.
    All,
    /// Those of these blocks of a picture of that size.
    Blocks(&'a Blocks, Size),
}

/// The pixels of `window` as red, green, blue and coverage. Where only blocks
/// are wanted, the others stay empty.
///
/// # Errors
/// Where the file is damaged, or a wanted pixel is missing.
pub fn pixels(
    file: impl Read + Seek,
    window: Window,
    wanted: Wanted<'_>,
) -> Result<Vec<[f32; 4]>, StateError> {
    pixels_as(file, window, wanted, [0.0; 4], |pixel| pixel)
}

/// What `of` makes of the pixels of `window`: red, green, blue and coverage. The
/// file is read block by block: five numbers a pixel are more than what is kept.
///
/// # Errors
/// As [`pixels`].
pub fn pixels_as<T: Clone>(
    mut file: impl Read + Seek,
    window: Window,
    wanted: Wanted<'_>,
    empty: T,
    of: impl Fn([f32; 4]) -> T,
) -> Result<Vec<T>, StateError> {
    let mut picture = vec![empty; window.pixels()];
    let mut covered = 0_usize;
    let mut bytes = Vec::new();
    read_part(&mut file, HEADER_BYTES, &mut bytes)?;
    is_known(&bytes)?;
    let ours = DoneRecord::new();
    // POV-Ray goes on where the mask ends: of small blocks it has many thousands.
    let mask = match wanted {
        Wanted::All => 0,
        Wanted::Blocks(wanted, size) => ours.bytes.len() * others(size, wanted),
    };
    let mut at = HEADER_BYTES + mask;
    file.seek(SeekFrom::Start(at as u64)).map_err(unreadable)?;
    // A record that is cut off at the end is left out, as POV-Ray does.
    while read_part(&mut file, RECORD_HEADER_BYTES, &mut bytes)? {
        let size = record_size(&bytes, at)?;
        if !read_part(&mut file, size, &mut bytes)? {
            break;
        }
        let begins = at;
        at += RECORD_HEADER_BYTES + size;
        let found = block(&bytes).ok_or(StateError::Record(begins))?;
        let Some(block) = found else { continue };
        let is_wanted = match wanted {
            Wanted::All => true,
            Wanted::Blocks(wanted, _) => wanted.numbers.binary_search(&block.id).is_ok(),
        };
        if !is_wanted {
            continue;
        }
        let part = block.window.intersection(window);
        covered += part.pixels();
        for y in part.y..part.bottom() {
            let row = (y - block.window.y) as usize * block.window.width as usize;
            let from = row + (part.x - block.window.x) as usize;
            let into =
                (y - window.y) as usize * window.width as usize + (part.x - window.x) as usize;
            let source = block.pixels[4 * CHANNELS * from..].chunks_exact(4 * CHANNELS);
            let target = &mut picture[into..into + part.width as usize];
            for (target, source) in target.iter_mut().zip(source) {
                *target = of(pixel(source));
            }
        }
    }
    let expected = match wanted {
        Wanted::All => window.pixels(),
        Wanted::Blocks(wanted, size) => wanted
            .windows(size)
            .map(|block| block.intersection(window).pixels())
            .sum(),
    };
    if covered < expected {
        return Err(StateError::Incomplete {
            missing: expected - covered,
            wanted: expected,
        });
    }
    Ok(picture)
}

/// Reads so many bytes in place of those before; `false` where fewer are left.
fn read_part(file: &mut impl Read, count: usize, bytes: &mut Vec<u8>) -> Result<bool, StateError> {
    bytes.clear();
    // A damaged size may be anything: memory is taken as bytes come.
    let read = file.by_ref().take(count as u64).read_to_end(bytes);
    Ok(read.map_err(unreadable)? == count)
}

fn unreadable(error: std::io::Error) -> StateError {
    StateError::Unreadable(error.kind())
}

/// POV-Ray keeps what passes through, not what is covered.
fn pixel(bytes: &[u8]) -> [f32; 4] {
    let [red, green, blue, _, transmit] = numbers(bytes);
    [red, green, blue, 1.0 - transmit]
}

fn numbers(bytes: &[u8]) -> [f32; CHANNELS] {
    std::array::from_fn(|k| {
        let at = 4 * k;
        f32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::io::Cursor;

    const SIZE: Size = Size {
        width: 70,
        height: 40,
    };

    #[test]
    fn a_mask_marks_every_other_block() {
        let ids = |wanted: &Blocks| -> Vec<u32> {
            let file = masked(SIZE, wanted);
            let record = DoneRecord::new();
            let records = file[HEADER_BYTES..].chunks(record.bytes.len());
            assert_eq!(records.len(), others(SIZE, wanted));
            let place = record.place;
            records.map(|one| be_u32(one, place).unwrap()).collect()
        };
        assert_eq!(ids(&Blocks::usual(vec![1, 5])), [0, 2, 3, 4]);
        let smaller = Blocks {
            side: 16,
            numbers: (2..15).collect(),
        };
        assert_eq!(ids(&smaller), [0, 1]);
        let file = masked(SIZE, &Blocks::usual(vec![1, 5]));
        assert!(blocks(&file).unwrap().is_empty(), "it shows nothing");
    }

    #[test]
    fn an_unfinished_render_is_noticed() {
        let error = pixels(Cursor::new(empty()), SIZE.window(), Wanted::All).unwrap_err();
        assert_eq!(
            error,
            StateError::Incomplete {
                missing: 2800,
                wanted: 2800
            }
        );
        let third = Blocks::usual(vec![3]);
        assert!(
            pixels(
                Cursor::new(masked(SIZE, &third)),
                SIZE.window(),
                Wanted::Blocks(&third, SIZE)
            )
            .is_err()
        );
    }

    #[test]
    fn another_format_is_refused() {
        assert_eq!(blocks(b"P6").unwrap_err(), StateError::Header);
        let mut newer = empty();
        newer[SIGNATURE.len() + 3] = b'2';
        assert_eq!(blocks(&newer).unwrap_err(), StateError::Header);
    }

    proptest! {
        #[test]
        fn damaged_files_do_not_panic(at in 512_usize..1100, byte: u8, cut in 0_usize..600) {
            let mut file = masked(SIZE, &Blocks::usual(vec![1]));
            let at = at % file.len();
            file[at] = byte;
            file.truncate(file.len().saturating_sub(cut));
            let _ = pixels(Cursor::new(&file), SIZE.window(), Wanted::All);
            let _ = blocks(&file);
        }
    }
}
