//! Pictures written from top to bottom, band by band, so that no whole film need be in memory.
//!
//! EXR files are scan lines (RLE) in rising order, written by a thread of their own, since the format's writer asks for its
//! blocks; their header, which comes first, keeps room for the record, which is known last. PNG and HDR files are written row by row. A file
//! is renamed to its name when it is finished. Memory: `Bands::bytes`.

use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::writer::ChunksWriter;
use exr::meta::attribute::ChannelDescription;
use exr::meta::header::{Header, ImageAttributes};
use exr::prelude::{
    AttributeValue, Compression, IntegerBounds, LayerAttributes, LineOrder, SampleType, SmallVec, Text, Vec2,
};

use super::look::Look;
use super::record::Record;
use super::{Format, exr as whole_exr, hdr, image};
use crate::error::Error;
use crate::film::aov::{self, Aovs, Names};
use crate::film::{Film, Tile};

/// Bytes kept in a header for the record at least: some ten times what one takes without its command and notes.
const RECORD_ROOM: usize = 64 << 10;
/// Scan lines on their way to an EXR's thread.
const LINES_AHEAD: usize = 16;

/// What the pictures are of.
pub struct Subject<'a> {
    pub window: Tile,
    /// Size of the whole image.
    pub whole: (u32, u32),
    pub aovs: Aovs,
    pub names: &'a Names,
    pub look: Look,
    /// Bytes of command and notes that the record will have.
    pub said: usize,
}

impl Subject<'_> {
    /// Bytes kept in a header for the record; characters that JSON escapes take two or more.
    fn record_room(&self) -> usize {
        RECORD_ROOM + 3 * self.said
    }
}

/// Pictures being written.
pub struct Bands {
    sinks: Vec<Sink>,
    look: Look,
    record_room: usize,
}

struct Sink {
    path: PathBuf,
    beside: PathBuf,
    kind: Kind,
}

enum Kind {
    /// Lines to the thread that writes them, each with how many times it stands.
    Exr(SyncSender<(Vec<u8>, u32)>, JoinHandle<Result<(), exr::error::Error>>),
    Png(Box<png::StreamWriter<'static, BufWriter<File>>>),
    Hdr(BufWriter<File>),
}

impl Bands {
    /// Begins every file.
    pub fn begin(paths: &[PathBuf], subject: &Subject) -> Result<Self, Error> {
        let mut bands = Self { sinks: Vec::new(), look: subject.look, record_room: subject.record_room() };
        for path in paths {
            let beside = super::beside(path);
            let file = File::create(&beside).map_err(|e| Error::io("write", path, e))?;
            let kind = begin(path, file, subject);
            if kind.is_err() {
                std::fs::remove_file(&beside).ok();
            }
            bands.sinks.push(Sink { path: path.clone(), beside, kind: kind? });
        }
        Ok(bands)
    }

    /// Most bytes held beside the film: the lines on their way.
    pub fn bytes(paths: &[PathBuf], subject: &Subject) -> usize {
        let exrs = paths.iter().filter(|p| matches!(Format::of(p), Ok(Format::Exr))).count();
        let channels = aov::channels(&Film::over(Tile::default(), subject.aovs, 0), subject.names).len();
        // Each line once as values and once compressed.
        exrs * (LINES_AHEAD + 2) * 2 * channels * 4 * subject.window.width as usize
    }

    /// Adds the rows of a film, which follow those before.
    pub fn write(&mut self, film: &Film) -> Result<(), Error> {
        let width = film.width() as usize;
        let mut channels = aov::channels(film, film.names());
        channels.sort_by(|a, b| a.name.cmp(&b.name));
        for row in 0..film.height() as usize {
            let pixels = row * width..(row + 1) * width;
            let radiance: Vec<[f32; 3]> = pixels.clone().map(|p| film.mean(p).map(|v| v as f32)).collect();
            for sink in &mut self.sinks {
                let written = match &mut sink.kind {
                    Kind::Exr(lines, _) => {
                        let values = channels.iter().flat_map(|c| pixels.clone().map(&c.value));
                        let line: Vec<u8> = values.flat_map(f32::to_ne_bytes).collect();
                        // The thread has ended early only with an error, which `finish` tells.
                        lines.send((line, 1)).ok();
                        Ok(())
                    }
                    Kind::Png(out) => {
                        let bytes: Vec<u8> = radiance.iter().flat_map(|&p| image::rgb8(p, &self.look)).collect();
                        out.write_all(&bytes)
                    }
                    Kind::Hdr(out) => hdr::write_pixels(out, &radiance),
                };
                written.map_err(|e| Error::io("write", &sink.path, e))?;
            }
        }
        Ok(())
    }

    /// Adds rows without samples, the last of the picture: `row` is the film of one. The line is made and compressed once, for an
    /// interrupt of a large picture must end soon.
    pub fn write_blank(&mut self, row: &Film, count: u32) -> Result<(), Error> {
        let width = row.width() as usize;
        let mut channels = aov::channels(row, row.names());
        channels.sort_by(|a, b| a.name.cmp(&b.name));
        for sink in &mut self.sinks {
            let written = match &mut sink.kind {
                Kind::Exr(lines, _) => {
                    let values = channels.iter().flat_map(|c| (0..width).map(&c.value));
                    lines.send((values.flat_map(f32::to_ne_bytes).collect(), count)).ok();
                    Ok(())
                }
                Kind::Png(out) => {
                    let black = image::rgb8([0.0; 3], &self.look).repeat(width);
                    (0..count).try_for_each(|_| out.write_all(&black))
                }
                // Black is four zeros, and what a file has not been given reads as zeros.
                Kind::Hdr(out) => out.flush().and_then(|()| {
                    let end = out.stream_position()? + u64::from(count) * width as u64 * 4;
                    out.get_ref().set_len(end)
                }),
            };
            written.map_err(|e| Error::io("write", &sink.path, e))?;
        }
        Ok(())
    }

    /// Ends every file, puts the record into headers, and renames.
    pub fn finish(mut self, record: &Record) -> Result<(), Error> {
        // One by one, so that an error leaves the rest to `drop`.
        while !self.sinks.is_empty() {
            let sink = self.sinks.remove(0);
            let path = sink.path.clone();
            let io = |e: std::io::Error| Error::io("write", &path, e);
            let ended = match sink.kind {
                Kind::Exr(lines, thread) => {
                    drop(lines);
                    let written = thread.join().expect("the writing thread does not panic");
                    written
                        .map_err(|e| exr_error(&path, e))
                        .and_then(|()| put_record(&sink.beside, &path, record, self.record_room))
                }
                Kind::Png(out) => out.finish().map_err(|e| Error::file(&path, format!("cannot write: {e}"))),
                Kind::Hdr(mut out) => out.flush().map_err(io),
            };
            let done = ended.and_then(|()| std::fs::rename(&sink.beside, &path).map_err(io));
            if done.is_err() {
                std::fs::remove_file(&sink.beside).ok();
            }
            done?;
        }
        Ok(())
    }
}

impl Drop for Bands {
    /// What was not finished leaves nothing behind.
    fn drop(&mut self) {
        for sink in self.sinks.drain(..) {
            if let Kind::Exr(lines, thread) = sink.kind {
                drop(lines);
                thread.join().ok();
            }
            std::fs::remove_file(&sink.beside).ok();
        }
    }
}

fn begin(path: &Path, file: File, subject: &Subject) -> Result<Kind, Error> {
    let (width, height) = (subject.window.width, subject.window.height);
    let mut out = BufWriter::with_capacity(1 << 20, file);
    match Format::of(path)? {
        Format::Hdr => {
            out.write_all(hdr::header(width, height).as_bytes()).map_err(|e| Error::io("write", path, e))?;
            Ok(Kind::Hdr(out))
        }
        Format::Png => {
            let mut encoder = png::Encoder::new(out, width, height);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            let writer = encoder.write_header().and_then(|w| w.into_stream_writer());
            writer.map(|w| Kind::Png(Box::new(w))).map_err(|e| Error::file(path, format!("cannot write: {e}")))
        }
        Format::Exr => {
            let header = exr_header(subject);
            let (sender, lines) = sync_channel::<(Vec<u8>, u32)>(LINES_AHEAD);
            let write = move || {
                exr::block::write(out, [header].into_iter().collect(), false, |meta, chunks| {
                    let mut indices = exr::block::enumerate_ordered_header_block_indices(&meta.headers);
                    while let Some((number, index)) = indices.next() {
                        let Ok((data, count)) = lines.recv() else {
                            return Err(exr::error::Error::Invalid("the picture ended before its last row".into()));
                        };
                        let block = UncompressedBlock { index, data };
                        let chunk = block.compress_to_chunk(&meta.headers)?;
                        let below = indices.by_ref().take(count.saturating_sub(1) as usize).zip(1..);
                        let equal: Vec<(usize, i32)> = below.map(|((number, _), down)| (number, down)).collect();
                        chunks.write_chunk(number, chunk.clone())?;
                        for (number, down) in equal {
                            chunks.write_chunk(number, lower(&chunk, down))?;
                        }
                    }
                    Ok(())
                })
            };
            Ok(Kind::Exr(sender, std::thread::spawn(write)))
        }
    }
}

/// The same scan line so many rows further down.
fn lower(chunk: &Chunk, rows: i32) -> Chunk {
    let mut copy = chunk.clone();
    if let CompressedBlock::ScanLine(line) = &mut copy.compressed_block {
        line.y_coordinate += rows;
    }
    copy
}

fn exr_header(subject: &Subject) -> Header {
    let film = Film::over(Tile::default(), subject.aovs, 0);
    let mut channels = aov::channels(&film, subject.names);
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    let descriptions: SmallVec<[ChannelDescription; 5]> =
        channels.iter().map(|c| ChannelDescription::new(c.name.as_str(), SampleType::F32, true)).collect();
    let mut attributes = LayerAttributes::default();
    let mut add = |name: &str, text: &str| {
        attributes.other.insert(Text::from(name), AttributeValue::Text(Text::from(text)));
    };
    channels.iter().for_each(|c| add(&format!("unit.{}", c.name), c.unit));
    aov::attributes(subject.aovs, subject.names).iter().for_each(|(name, text)| add(name, text));
    add(whole_exr::RECORD_ATTRIBUTE, &" ".repeat(subject.record_room()));
    attributes.layer_position = Vec2(subject.window.x as i32, subject.window.y as i32);
    let size = Vec2(subject.window.width as usize, subject.window.height as usize);
    let display = IntegerBounds::from_dimensions(Vec2(subject.whole.0 as usize, subject.whole.1 as usize));
    Header::new(Text::default(), size, descriptions)
        .with_encoding(Compression::RLE, exr::meta::BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(attributes)
        .with_shared_attributes(ImageAttributes::new(display))
}

fn exr_error(path: &Path, error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::Io(e) => Error::io("write", path, e),
        other => Error::file(path, format!("cannot write: {other}")),
    }
}

/// The record in at most `room` bytes: what is too long is cut, and says so. Nothing that was rendered is lost for want of a note.
fn fitted(record: &Record, room: usize) -> serde_json::Result<String> {
    let mut json = serde_json::to_string(record)?;
    let mut cut = record.clone();
    while json.len() > room && !cut.notes.is_empty() {
        cut.notes.truncate(cut.notes.len() / 2);
        let mut shown = cut.clone();
        let left_out = record.notes.len() - cut.notes.len();
        shown.notes.push(format!("{left_out} more notes had no room in this header; stderr and --record have them"));
        json = serde_json::to_string(&shown)?;
        if cut.notes.is_empty() {
            cut = shown;
            break;
        }
    }
    if json.len() > room {
        let command = cut.command.chars().take(1000).collect::<String>();
        cut.command = format!("{command} ... (cut: no room in this header)");
        json = serde_json::to_string(&cut)?;
    }
    Ok(json)
}

/// Writes the record over the room that the header kept for it.
fn put_record(file: &Path, path: &Path, record: &Record, room: usize) -> Result<(), Error> {
    let json = fitted(record, room).map_err(|e| Error::file(path, format!("cannot write its record: {e}")))?;
    if json.len() > room {
        return Err(Error::file(path, "cannot write its record: it is longer than the room in the header"));
    }
    let io = |e: std::io::Error| Error::io("write", path, e);
    let mut file = File::options().read(true).write(true).open(file).map_err(io)?;
    // An attribute is its name, its type, its length and its bytes; names and types end in 0.
    let mark = [whole_exr::RECORD_ATTRIBUTE.as_bytes(), b"\0string\0", &(room as u32).to_le_bytes()].concat();
    let (mut head, mut at) = (Vec::new(), None);
    while at.is_none() {
        let before = head.len();
        (&mut file).take(1 << 20).read_to_end(&mut head).map_err(io)?;
        at = head.windows(mark.len()).position(|w| w == mark);
        if head.len() == before {
            break;
        }
    }
    let at = at.ok_or_else(|| Error::file(path, "cannot write its record: the header has no room for it"))?;
    file.seek(SeekFrom::Start((at + mark.len()) as u64)).map_err(io)?;
    file.write_all(json.as_bytes()).map_err(io)
}
