//! Images as sequences of patches (thesis 3.3.2; Dosovitskiy et al. 2021).

use burn::tensor::Tensor;

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

/// Patches row by row, each with its pixels row by row and the channels innermost. A linear map of these is a convolution
/// with kernel and stride `patch`.
///
/// # Shapes
/// `[B, channels, height, width]` to `[B, patches, patch² channels]`.
///
/// # Errors
/// The patches do not tile the image.
pub fn split(images: Tensor<4>, patch: usize) -> Result<Tensor<3>, Untiled> {
    let [b, channels, height, width] = images.dims();
    let [rows, columns] = tiles(patch, height, width)?;
    let tiled = images.reshape([b, channels, rows, patch, columns, patch]).permute([0, 2, 4, 3, 5, 1]);
    Ok(tiled.reshape([b, rows * columns, patch * patch * channels]))
}

/// Returns the image again.
///
/// # Shapes
/// `[B, patches, patch² channels]` to `[B, channels, height, width]`.
///
/// # Errors
/// The patches do not tile the image, or are not as many as it needs.
pub fn join(patches: Tensor<3>, patch: usize, [height, width]: [usize; 2]) -> Result<Tensor<4>, Untiled> {
    let [b, count, numbers] = patches.dims();
    let [rows, columns] = tiles(patch, height, width)?;
    let channels = numbers / (patch * patch);
    if count != rows * columns || numbers != channels * patch * patch {
        return Err(Untiled { patch, height, width });
    }
    let tiled = patches.reshape([b, rows, columns, patch, patch, channels]).permute([0, 5, 1, 3, 2, 4]);
    Ok(tiled.reshape([b, channels, height, width]))
}

/// Returns the index in the image of each number of its patches, for images row by row with the channels innermost, as files
/// have them: the order of [`split`] without a tensor.
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
    use crate::device;
    use burn::tensor::TensorData;

    #[test]
    fn patches_are_the_images_pixels_and_join_again() {
        let values: Vec<f32> = (0..2 * 3 * 4 * 8).map(|i| i as f32).collect();
        let images = Tensor::<4>::from_data(TensorData::new(values.clone(), [2, 3, 4, 8]), &device::inference());
        let split = split(images, 2).unwrap();
        assert_eq!(split.dims(), [2, 8, 12]);
        let numbers = split.clone().try_into_vec_as::<f32>().unwrap();
        // Second image, patch in row 1 and column 2 (number 6), its pixel (1, 0), channel 2: pixel (3, 4) of the image.
        assert_eq!(numbers[8 * 12 + 6 * 12 + (2 * 3) + 2], values[3 * 32 + 2 * 32 + 3 * 8 + 4]);
        assert_eq!(join(split, 2, [4, 8]).unwrap().try_into_vec_as::<f32>().unwrap(), values);
    }

    #[test]
    fn the_order_without_tensors_is_the_same() {
        let (channels, height, width) = (3, 4, 8);
        let pixels: Vec<f32> = (0..channels * height * width).map(|i| i as f32).collect();
        let image = Tensor::<1>::from_data(TensorData::new(pixels.clone(), [96]), &device::inference());
        let image = image.reshape([1, height, width, channels]).permute([0, 3, 1, 2]);
        let numbers = split(image, 2).unwrap().try_into_vec_as::<f32>().unwrap();
        let ordered: Vec<f32> = order(2, [height, width], channels).unwrap().iter().map(|&i| pixels[i]).collect();
        assert_eq!(ordered, numbers);
        assert!(order(3, [height, width], channels).is_err());
    }

    #[test]
    fn what_does_not_tile_is_refused() {
        let images = Tensor::<4>::zeros([1, 3, 4, 6], &device::inference());
        let error = split(images.clone(), 4).unwrap_err().to_string();
        assert!(error.contains("4 x 6"), "{error}");
        assert!(split(images.clone(), 0).is_err());
        assert!(join(split(images, 2).unwrap(), 2, [4, 4]).is_err());
    }
}
