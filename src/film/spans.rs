//! Work that is not the same for all pixels: a list of blocks by pixel, and the slots that come back for it.

use rayon::prelude::*;

use super::slot::SLOT_ROWS;
use super::{Events, Film};

/// Blocks first, first + 1, ... of one pixel of a film's window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    pub pixel: u32,
    pub first: u64,
    pub count: u32,
}

/// Takes a list in parts of a given number of slots; a span may be cut.
pub struct Parts<'a> {
    rest: &'a [Span],
    /// Blocks of the first span that were handed out.
    taken: u32,
}

impl<'a> Parts<'a> {
    pub fn of(spans: &'a [Span]) -> Self {
        Self { rest: spans, taken: 0 }
    }

    /// The next spans, of `limit` > 0 slots together, or what is left; None when nothing is.
    pub fn next(&mut self, limit: usize) -> Option<Vec<Span>> {
        let mut part = Vec::new();
        let mut left = limit;
        while let (Some(span), true) = (self.rest.first(), left > 0) {
            let count = ((span.count - self.taken) as usize).min(left);
            if count > 0 {
                part.push(Span { first: span.first + u64::from(self.taken), count: count as u32, ..*span });
            }
            left -= count;
            self.taken += count as u32;
            if self.taken == span.count {
                (self.rest, self.taken) = (&self.rest[1..], 0);
            }
        }
        (!part.is_empty()).then_some(part)
    }
}

/// Slots of a list.
pub fn slot_count(spans: &[Span]) -> usize {
    spans.iter().map(|s| s.count as usize).sum()
}

impl Film {
    /// Adds the slots of `spans`, whose pixels ascend: one span after the other, and in each block by block. Returns the rays counted
    /// in them.
    pub fn add_spans(&mut self, spans: &[Span], rows: &[[u32; 4]]) -> u64 {
        assert!(spans.windows(2).all(|w| w[0].pixel < w[1].pixel), "pixels ascend");
        let (Some(first), Some(last)) = (spans.first(), spans.last()) else { return 0 };
        let rows_a_slot = SLOT_ROWS + self.layout.rows;
        assert!(rows.len() >= slot_count(spans) * rows_a_slot, "the list's slots are all there");
        let window = self.window;
        let row_of = |span: &Span| (span.pixel / window.width) as usize;
        let (top, bottom) = (row_of(first), row_of(last) + 1);
        // Of every image row its spans, and where their slots begin.
        let (mut rest, mut begin) = (spans, 0);
        let by_row: Vec<(&[Span], usize)> = (top..bottom)
            .map(|row| {
                let (own, after) = rest.split_at(rest.partition_point(|s| row_of(s) == row));
                let from = begin;
                (rest, begin) = (after, begin + slot_count(own));
                (own, from)
            })
            .collect();
        let events: Vec<Events> = (self.image_rows(top..bottom).into_par_iter().zip(by_row))
            .map(|(mut sums, (spans, mut slot))| {
                let mut events = Events::default();
                for span in spans {
                    let x = span.pixel % window.width;
                    let position = (window.x + x, window.y + span.pixel / window.width);
                    for block in span.first..span.first + u64::from(span.count) {
                        let rows = &rows[slot * rows_a_slot..][..rows_a_slot];
                        sums.add(x as usize, position, block, rows, &mut events);
                        slot += 1;
                    }
                }
                events
            })
            .collect();
        self.take_all(events)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_every_block_once_and_in_order() {
        let span = |pixel, first, count| Span { pixel, first, count };
        let spans = [span(1, 0, 3), span(4, 7, 0), span(5, 2, 9), span(6, 1, 1)];
        let blocks = |spans: &[Span]| -> Vec<(u32, u64)> {
            spans.iter().flat_map(|s| (s.first..s.first + u64::from(s.count)).map(|b| (s.pixel, b))).collect()
        };
        for limit in [1, 2, 3, 5, 13, 100] {
            let (mut parts, mut all) = (Parts::of(&spans), Vec::new());
            while let Some(part) = parts.next(limit) {
                assert!(slot_count(&part) <= limit);
                all.extend(blocks(&part));
            }
            assert_eq!(all, blocks(&spans), "{limit}");
        }
        assert_eq!(Parts::of(&[]).next(4), None);
    }
}
