//! A folder of images of one size: `train/` and `test/`, files of any depth below.

use std::path::{Path, PathBuf};

use lifelike_checkpoint::FromInput;
use lifelike_motion::dataset::find_files;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::SequencesError;
use super::pixels::{self, is_image};

/// Images, a byte for each number: CIFAR-10 is 184 MB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFolder {
    /// Rows and columns of every image.
    pub size: [usize; 2],
    /// To train on and to watch the loss on.
    pub train: Vec<Vec<u8>>,
    /// For the table.
    pub test: Vec<Vec<u8>>,
    /// Of all pixels.
    pub(super) digest: String,
}

impl ImageFolder {
    /// Red, green and blue.
    pub const CHANNELS: usize = 3;

    /// Reads every `.png`, `.jpg` and `.jpeg` under `train/` and `test/`, sorted by path. Grey images become red,
    /// green and blue alike.
    ///
    /// # Shapes
    /// Images are `[rows, columns, 3]`.
    ///
    /// # Errors
    /// A folder that is not there or has no images; a file that is no image or of another size than the first.
    pub fn read(folder: &Path) -> Result<Self, SequencesError> {
        let files = ["train", "test"].map(|part| {
            let part = folder.join(part);
            if !part.is_dir() {
                let expected = "a folder with the folders train and test, of PNG or JPEG images";
                let got = format!("no folder {}", part.display());
                return Err(SequencesError::format(folder.display(), expected, got));
            }
            Ok(find_files(&[part], is_image)?)
        });
        let [train, test] = files;
        let (train, test) = (train?, test?);
        let first = &train[0];
        let size = pixels::read(first)?.size;
        let read = |path: &PathBuf| {
            let image = pixels::read(path)?;
            if image.size == size {
                return Ok(image.rgb);
            }
            let said = |[rows, columns]: [usize; 2]| format!("{columns} x {rows} pixels");
            let expected = format!("{}, the size of {}", said(size), first.display());
            Err(SequencesError::format(path.display(), expected, said(image.size)))
        };
        let [train, test] = [&train, &test].map(|files| files.par_iter().map(read).collect::<Result<Vec<_>, _>>());
        let (train, test) = (train?, test?);
        let mut hash = Sha256::new();
        train.iter().chain(&test).for_each(|image| hash.update(image));
        let digest = hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect();
        Ok(Self { size, train, test, digest })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use zune_core::bit_depth::BitDepth;
    use zune_core::colorspace::ColorSpace;
    use zune_core::options::EncoderOptions;
    use zune_png::PngEncoder;

    use super::*;

    /// An image of one grey.
    fn put(folder: &Path, name: &str, side: usize, grey: u8) {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut file = Vec::new();
        let options = EncoderOptions::new(side, side, ColorSpace::Luma, BitDepth::Eight);
        PngEncoder::new(&vec![grey; side * side], options).encode(&mut file).unwrap();
        std::fs::write(path, file).unwrap();
    }

    #[test]
    fn images_are_read_in_the_order_of_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        put(at, "train/b/1.png", 2, 20);
        put(at, "train/a/2.png", 2, 10);
        put(at, "test/1.PNG", 2, 30);
        std::fs::write(at.join("train/README.md"), "notes").unwrap();
        let read = ImageFolder::read(at).unwrap();
        assert_eq!((read.size, read.train, read.test), ([2, 2], vec![vec![10; 12], vec![20; 12]], vec![vec![30; 12]]));
        put(at, "test/1.PNG", 2, 31);
        assert_ne!(ImageFolder::read(at).unwrap().digest, read.digest);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let error = || ImageFolder::read(at).unwrap_err().to_string();
        assert!(error().contains("expected a folder with the folders train and test") && error().contains("train"));
        put(at, "train/1.png", 2, 1);
        assert!(error().contains("no folder") && error().ends_with("test"), "{}", error());
        std::fs::create_dir(at.join("test")).unwrap();
        assert!(error().contains("nothing of the kind"), "{}", error());
        put(at, "test/7.png", 3, 1);
        assert!(error().contains("7.png: expected 2 x 2 pixels, the size of") && error().ends_with("got 3 x 3 pixels"));
        std::fs::write(at.join("test/7.png"), "hello").unwrap();
        assert!(error().contains("7.png: expected an image as PNG or JPEG, got something else"), "{}", error());
    }
}
