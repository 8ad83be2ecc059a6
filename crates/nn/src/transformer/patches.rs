//! Images as sequences of patches (thesis 3.3.2; Dosovitskiy et al. 2021).

/// An image whose sides its patches do not tile.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("patches of {patch} x {patch} pixels do not tile {height} x {width}")]
pub struct Untiled {
    /// Side of a patch.
    pub patch: usize,
    /// Rows, pixels.
    pub height: usize,
    /// Columns, pixels.
    pub width: usize,
}

/// Returns the index in the image of each number of its patches, for images row by row with the channels innermost, as files
/// have them. Patches go row by row, each with its pixels row by row and the channels innermost. A linear map of these is a
/// convolution with kernel and stride `patch`.
///
/// # Shapes
/// `height width channels` numbers, each once.
///
/// # Errors
/// The patches do not tile the image.
pub fn order(patch: usize, [height, width]: [usize; 2], channels: usize) -> Result<Vec<usize>, Untiled> {
    let [rows, columns] = tiles(patch, height, width)?;
    let mut order = Vec::with_capacity(height * width * channels);
    for tile in 0..rows * columns {
        let (top, left) = (tile / columns * patch, tile % columns * patch);
        for pixel in 0..patch * patch {
            let first = ((top + pixel / patch) * width + left + pixel % patch) * channels;
            order.extend(first..first + channels);
        }
    }
    Ok(order)
}

fn tiles(patch: usize, height: usize, width: usize) -> Result<[usize; 2], Untiled> {
    if patch == 0 || !height.is_multiple_of(patch) || !width.is_multiple_of(patch) {
        return Err(Untiled { patch, height, width });
    }
    Ok([height / patch, width / patch])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_order_is_that_of_patches_and_has_each_number_once() {
        let (channels, height, width) = (3, 4, 8);
        let order = order(2, [height, width], channels).unwrap();
        // Patch in row 1 and column 2 (number 6), its pixel (1, 0), channel 2: pixel (3, 4) of the image.
        assert_eq!(order[6 * 12 + 2 * 3 + 2], (3 * width + 4) * channels + 2);
        let mut sorted = order;
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..channels * height * width));
    }

    #[test]
    fn an_image_that_patches_do_not_tile_is_refused() {
        let error = order(4, [4, 6], 3).unwrap_err().to_string();
        assert!(error.contains("4 x 6"), "{error}");
        assert!(order(0, [4, 6], 3).is_err() && order(3, [4, 8], 3).is_err());
    }
}
