//! One track of H.264 as an MP4 file (ISO/IEC 14496-12, 14496-14 and 14496-15).

/// Ticks of the file's clock in a second.
const TIMESCALE: u32 = 90_000;
/// No rotation and no scale, as 16.16 and 2.30 fixed-point numbers.
const IDENTITY: [u32; 9] = [0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000];

/// One encoded frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sample {
    /// True if a player may begin here.
    pub is_key: bool,
    /// Units of H.264, each after its length.
    pub data: Vec<u8>,
}

/// Bytes of a box, big-endian.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn u16s(mut self, values: &[u16]) -> Self {
        values.iter().for_each(|v| self.0.extend(v.to_be_bytes()));
        self
    }

    fn u32s(mut self, values: &[u32]) -> Self {
        values.iter().for_each(|v| self.0.extend(v.to_be_bytes()));
        self
    }

    fn raw(mut self, bytes: &[u8]) -> Self {
        self.0.extend(bytes);
        self
    }

    /// Returns the box of this type with these bytes.
    fn boxed(self, kind: &[u8; 4]) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.0.len() + 8);
        out.extend((self.0.len() as u32 + 8).to_be_bytes());
        out.extend(kind);
        out.extend(self.0);
        out
    }
}

fn bytes() -> Bytes {
    Bytes::default()
}

/// Returns a box that contains boxes.
fn nested(kind: &[u8; 4], inner: &[Vec<u8>]) -> Vec<u8> {
    bytes().raw(&inner.concat()).boxed(kind)
}

/// Returns the file; `avcc` is the decoder's configuration record.
pub(super) fn muxed(samples: &[Sample], avcc: &[u8], size: (u32, u32), fps: f64) -> Vec<u8> {
    let tick = (f64::from(TIMESCALE) / fps).round() as u32;
    let length = tick * samples.len() as u32;
    let kind = bytes().raw(b"isom").u32s(&[0x200]).raw(b"isomiso2avc1mp41").boxed(b"ftyp");
    // The table of samples needs their place, which depends on its own length: that is known once it is made.
    let head = movie(samples, avcc, size, (tick, length), 0).len();
    let place = kind.len() + head + 8;
    let head = movie(samples, avcc, size, (tick, length), place as u32);
    let data: Vec<u8> = samples.iter().flat_map(|s| s.data.iter().copied()).collect();
    [kind, head, bytes().raw(&data).boxed(b"mdat")].concat()
}

fn movie(samples: &[Sample], avcc: &[u8], size: (u32, u32), (tick, length): (u32, u32), place: u32) -> Vec<u8> {
    let header = bytes().u32s(&[0, 0, 0, TIMESCALE, length, 0x1_0000]).u16s(&[0x100, 0]).u32s(&[0, 0]);
    let header = header.u32s(&IDENTITY).u32s(&[0; 6]).u32s(&[2]).boxed(b"mvhd");
    let (width, height) = size;
    let track = bytes().u32s(&[7, 0, 0, 1, 0, length, 0, 0]).u16s(&[0, 0, 0, 0]).u32s(&IDENTITY);
    let track = track.u32s(&[width << 16, height << 16]).boxed(b"tkhd");
    // 0x55c4 is the language code of "undetermined".
    let media = bytes().u32s(&[0, 0, 0, TIMESCALE, length]).u16s(&[0x55c4, 0]).boxed(b"mdhd");
    let handler = bytes().u32s(&[0, 0]).raw(b"vide").u32s(&[0; 3]).raw(b"video\0").boxed(b"hdlr");
    let video = bytes().u32s(&[1, 0, 0]).boxed(b"vmhd");
    let here = bytes().u32s(&[1]).boxed(b"url ");
    let reference = nested(b"dinf", &[bytes().u32s(&[0, 1]).raw(&here).boxed(b"dref")]);
    let table = sample_table(samples, avcc, size, tick, place);
    let information = nested(b"minf", &[video, reference, table]);
    let trak = nested(b"trak", &[track, nested(b"mdia", &[media, handler, information])]);
    nested(b"moov", &[header, trak])
}

fn sample_table(samples: &[Sample], avcc: &[u8], (width, height): (u32, u32), tick: u32, place: u32) -> Vec<u8> {
    let n = samples.len() as u32;
    let entry = bytes().u16s(&[0, 0, 0, 1]).u32s(&[0; 4]).u16s(&[width as u16, height as u16]);
    // 72 dpi, one frame a sample, no name of a compressor, 24 bits of colour.
    let entry = entry.u32s(&[0x48_0000, 0x48_0000, 0]).u16s(&[1]).raw(&[0; 32]).u16s(&[24, 0xffff]);
    let entry = entry.raw(&bytes().raw(avcc).boxed(b"avcC")).boxed(b"avc1");
    let description = bytes().u32s(&[0, 1]).raw(&entry).boxed(b"stsd");
    let times = bytes().u32s(&[0, 1, n, tick]).boxed(b"stts");
    let keys: Vec<u32> = (1..=n).zip(samples).filter(|(_, s)| s.is_key).map(|(number, _)| number).collect();
    let keys = bytes().u32s(&[0, keys.len() as u32]).u32s(&keys).boxed(b"stss");
    let chunks = bytes().u32s(&[0, 1, 1, n, 1]).boxed(b"stsc");
    let sizes: Vec<u32> = samples.iter().map(|s| s.data.len() as u32).collect();
    let sizes = bytes().u32s(&[0, 0, n]).u32s(&sizes).boxed(b"stsz");
    let offsets = bytes().u32s(&[0, 1, place]).boxed(b"stco");
    nested(b"stbl", &[description, times, keys, chunks, sizes, offsets])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_points_at_the_first_sample() {
        let samples = [(true, vec![1, 2, 3]), (false, vec![4])].map(|(is_key, data)| Sample { is_key, data });
        let file = muxed(&samples, &[1, 0x64], (64, 48), 25.0);
        let place_of = |kind: &[u8]| file.windows(4).position(|w| w == kind).unwrap_or(0);
        let word = |i: usize| u32::from_be_bytes([file[i], file[i + 1], file[i + 2], file[i + 3]]);
        let place = word(place_of(b"stco") + 12) as usize;
        assert_eq!(&file[place..], [1, 2, 3, 4], "the last box ends with the samples");
        assert_eq!(place, place_of(b"mdat") + 4);
        // Boxes at the top follow each other to the end of the file.
        let second = word(0) as usize;
        let third = second + word(second) as usize;
        assert_eq!(third + word(third) as usize, file.len());
        assert_eq!(word(place_of(b"stts") + 16), 3600, "90,000 ticks a second at 25 frames a second");
    }
}
