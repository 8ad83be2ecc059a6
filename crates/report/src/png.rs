//! Pictures of 8 bits a channel as PNG files.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, Encoder, Transformations};

/// Returns a picture of `size` (width, height) as a file; nothing where the pixels are of another number.
pub(crate) fn encode(rgb: &[u8], size: (u32, u32)) -> Option<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, size.0, size.1);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(rgb)).ok()?;
    Some(file)
}

/// Returns size and pixels (red, green, blue) of a file; nothing where it is no picture.
pub(crate) fn decode(file: &[u8]) -> Option<((u32, u32), Vec<u8>)> {
    let mut decoder = Decoder::new(Cursor::new(file));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().ok()?;
    let mut bytes = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut bytes).ok()?;
    let channels = info.color_type.samples();
    let colour = |p: &[u8]| if channels < 3 { [p[0]; 3] } else { [p[0], p[1], p[2]] };
    Some(((info.width, info.height), bytes.chunks_exact(channels).flat_map(colour).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_and_a_wrong_size_is_refused() {
        let rgb: Vec<u8> = (0..18).map(|i| i * 11).collect();
        assert_eq!(encode(&rgb, (3, 2)).and_then(|file| decode(&file)), Some(((3, 2), rgb.clone())));
        assert_eq!(encode(&rgb, (3, 3)), None);
        assert_eq!(decode(b"no picture"), None);
    }
}
