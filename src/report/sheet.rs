//! A contact sheet: pictures of one size in a grid, each with its number in the corner.

use crate::output::image::{Picture, srgb_encode};

/// Pixels between cells.
const GAP: usize = 2;
const BACKGROUND: [u8; 3] = [24, 24, 24];

/// Digits of 3 x 5 dots, row by row, the left dot in the highest of three bits.
const DIGITS: [[u8; 5]; 10] = [
    [7, 5, 5, 5, 7],
    [2, 6, 2, 2, 7],
    [7, 1, 7, 4, 7],
    [7, 1, 7, 1, 7],
    [5, 5, 7, 1, 1],
    [7, 4, 7, 1, 7],
    [7, 4, 7, 5, 7],
    [7, 1, 1, 1, 1],
    [7, 5, 7, 5, 7],
    [7, 5, 7, 1, 7],
];

/// Width, height and sRGB bytes of the sheet; cells count from 1, row by row. All pictures have the size of the first.
pub fn lay_out(pictures: &[Picture], columns: usize) -> (u32, u32, Vec<u8>) {
    let [w, h] = pictures.first().map_or([0, 0], |p| [p.width as usize, p.height as usize]);
    let (width, height) = (columns * (w + GAP) + GAP, pictures.len().div_ceil(columns) * (h + GAP) + GAP);
    let mut pixels = vec![BACKGROUND; width * height];
    for (number, picture) in pictures.iter().enumerate() {
        let corner = [GAP + number % columns * (w + GAP), GAP + number / columns * (h + GAP)];
        for (i, pixel) in picture.pixels.iter().enumerate().take(w * h) {
            let at = (corner[1] + i / w) * width + corner[0] + i % w;
            pixels[at] = pixel.map(|x| (srgb_encode(x) * 255.0 + 0.5) as u8);
        }
        write_number(&mut pixels, width, corner, number + 1);
    }
    (width as u32, height as u32, pixels.into_iter().flatten().collect())
}

/// White digits on a dark plate, dots of one pixel.
fn write_number(pixels: &mut [[u8; 3]], width: usize, corner: [usize; 2], number: usize) {
    let text = number.to_string();
    for y in 0..7 {
        for x in 0..4 * text.len() + 1 {
            if let Some(pixel) = pixels.get_mut((corner[1] + y) * width + corner[0] + x) {
                *pixel = BACKGROUND;
            }
        }
    }
    for (place, digit) in text.bytes().enumerate() {
        for (y, row) in DIGITS[usize::from(digit - b'0')].iter().enumerate() {
            for x in (0..3).filter(|x| row >> (2 - x) & 1 == 1) {
                let at = (corner[1] + 1 + y) * width + corner[0] + 1 + 4 * place + x;
                if let Some(pixel) = pixels.get_mut(at) {
                    *pixel = [255; 3];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stand_in_rows() {
        let cell = |v: f32| Picture { width: 12, height: 9, pixels: vec![[v; 3]; 108] };
        let (width, height, bytes) = lay_out(&[cell(0.0), cell(1.0), cell(0.0)], 2);
        assert_eq!((width, height, bytes.len()), (30, 24, 30 * 24 * 3));
        let at = |x: usize, y: usize| bytes[(y * 30 + x) * 3];
        assert_eq!((at(0, 0), at(13, 10), at(27, 10), at(13, 21), at(27, 21)), (24, 0, 255, 0, 24));
        // The middle dot of the 1 in the first cell.
        assert_eq!(at(2 + 1 + 1, 2 + 1 + 2), 255);
    }
}
