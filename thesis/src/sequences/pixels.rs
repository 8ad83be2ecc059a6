//! One image file as pixels.

use std::panic::catch_unwind;
use std::path::Path;

use lifelike_checkpoint::FromInput;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;
use zune_png::PngDecoder;

use super::SequencesError;

/// Pixels of one image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pixels {
    /// Rows and columns.
    pub size: [usize; 2],
    /// `[rows, columns, 3]`: red, green, blue.
    pub rgb: Vec<u8>,
}

/// Returns whether a file's name says that it is an image that can be read.
pub(super) fn is_image(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    matches!(extension.as_deref(), Some("png" | "jpg" | "jpeg"))
}

/// Reads a PNG or JPEG, whichever its content is. Grey becomes red, green and blue alike; opacity is left out; of 16
/// bits the upper 8 are taken.
pub(super) fn read(path: &Path) -> Result<Pixels, SequencesError> {
    let bytes = std::fs::read(path).map_err(SequencesError::io(path))?;
    let decoded = match bytes.as_slice() {
        // The decoders are not proof against every broken file.
        [0xff, 0xd8, ..] => catch_unwind(|| jpeg(&bytes)),
        [0x89, b'P', b'N', b'G', ..] => catch_unwind(|| png(&bytes)),
        _ => Ok(Err("something else".into())),
    };
    decoded
        .unwrap_or_else(|_| Err("a broken one".into()))
        .map_err(|got| SequencesError::format(path.display(), "an image as PNG or JPEG", got))
}

fn jpeg(bytes: &[u8]) -> Result<Pixels, String> {
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let rgb = decoder.decode().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions().ok_or("no size")?;
    whole(rgb, width, height)
}

fn png(bytes: &[u8]) -> Result<Pixels, String> {
    let options = DecoderOptions::default().png_set_strip_to_8bit(true);
    let mut decoder = PngDecoder::new_with_options(ZCursor::new(bytes), options);
    let numbers = decoder.decode_raw().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions().ok_or("no size")?;
    let rgb = match decoder.colorspace() {
        Some(ColorSpace::RGB) => numbers,
        Some(ColorSpace::RGBA) => numbers.as_chunks::<4>().0.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect(),
        Some(ColorSpace::Luma) => numbers.iter().flat_map(|y| [*y; 3]).collect(),
        Some(ColorSpace::LumaA) => numbers.as_chunks::<2>().0.iter().flat_map(|[y, _]| [*y; 3]).collect(),
        other => return Err(format!("colours as {other:?}")),
    };
    whole(rgb, width, height)
}

fn whole(rgb: Vec<u8>, width: usize, height: usize) -> Result<Pixels, String> {
    if rgb.is_empty() || rgb.len() != 3 * width * height {
        return Err(format!("{} numbers for {width} x {height} pixels", rgb.len()));
    }
    Ok(Pixels { size: [height, width], rgb })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use zune_core::bit_depth::BitDepth;
    use zune_core::options::EncoderOptions;
    use zune_png::PngEncoder;

    use super::*;

    fn read_bytes(bytes: &[u8]) -> Result<Pixels, SequencesError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, bytes).unwrap();
        read(&path)
    }

    #[test]
    fn every_kind_of_png_becomes_red_green_and_blue() {
        let file = |numbers: &[u8], space: ColorSpace| {
            let mut file = Vec::new();
            let options = EncoderOptions::new(2, 1, space, BitDepth::Eight);
            PngEncoder::new(numbers, options).encode(&mut file).unwrap();
            read_bytes(&file).unwrap()
        };
        let expected = |rgb: [u8; 6]| Pixels { size: [1, 2], rgb: rgb.to_vec() };
        assert_eq!(file(&[1, 2, 3, 4, 5, 6], ColorSpace::RGB), expected([1, 2, 3, 4, 5, 6]));
        assert_eq!(file(&[1, 2, 3, 0, 4, 5, 6, 9], ColorSpace::RGBA), expected([1, 2, 3, 4, 5, 6]));
        assert_eq!(file(&[7, 8], ColorSpace::Luma), expected([7, 7, 7, 8, 8, 8]));
        assert_eq!(file(&[7, 0, 8, 255], ColorSpace::LumaA), expected([7, 7, 7, 8, 8, 8]));
    }

    /// Three columns and two rows of a palette of red, green, blue and nearly black: 0 1 2 / 3 2 1.
    const PALETTE: [u8; 93] = [
        137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 3, 0, 0, 0, 2, 2, 3, 0, 0, 0, 224, 26,
        142, 137, 0, 0, 0, 12, 80, 76, 84, 69, 255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9, 92, 113, 126, 134, 0, 0, 0,
        12, 73, 68, 65, 84, 120, 156, 99, 144, 96, 120, 2, 0, 1, 48, 0, 253, 86, 205, 28, 115, 0, 0, 0, 0, 73, 69, 78,
        68, 174, 66, 96, 130,
    ];

    #[test]
    fn palettes_are_looked_up() {
        let rgb = [255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9, 0, 0, 255, 0, 255, 0].to_vec();
        assert_eq!(read_bytes(&PALETTE).unwrap(), Pixels { size: [2, 3], rgb });
    }

    #[test]
    fn a_jpeg_has_its_colours_where_they_belong() {
        // 24 x 16: the left 16 columns (200, 40, 40), the right 8 (40, 40, 200).
        let pixels = read_bytes(include_bytes!("../../tests/fixtures/two-colours.jpg")).unwrap();
        assert_eq!(pixels.size, [16, 24]);
        let at = |row: usize, column: usize| &pixels.rgb[3 * (24 * row + column)..][..3];
        let near = |got: &[u8], expected: [u8; 3]| got.iter().zip(expected).all(|(a, b)| a.abs_diff(b) < 12);
        assert!(near(at(3, 4), [200, 40, 40]) && near(at(15, 20), [40, 40, 200]), "{:?} {:?}", at(3, 4), at(15, 20));
    }

    #[test]
    fn what_is_no_image_is_named() {
        let error = read_bytes(b"hello").unwrap_err().to_string();
        assert!(error.contains("a.png: expected an image as PNG or JPEG, got something else"), "{error}");
        for cut in 1..PALETTE.len() - 12 {
            let error = read_bytes(&PALETTE[..cut]).unwrap_err().to_string();
            assert!(error.contains("a.png: expected an image"), "{cut}: {error}");
        }
        let jpeg = include_bytes!("../../tests/fixtures/two-colours.jpg");
        assert!(read_bytes(&jpeg[..40]).is_err());
        assert!(read(Path::new("none.png")).unwrap_err().to_string().starts_with("none.png"));
    }
}
