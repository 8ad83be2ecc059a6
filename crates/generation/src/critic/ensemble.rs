//! The least of several networks: motion is promised no more than the most doubtful of them does.

use super::network::CriticNetwork;
use super::windows::PaddedRows;

/// Returns the least of the networks' values at every row, and the number of the network that gives it.
pub(super) fn least(networks: &[CriticNetwork], motion: &PaddedRows) -> (Vec<f32>, Vec<usize>) {
    least_of(networks.iter().map(|network| network.values(motion)))
}

/// Returns the least of several values of every row, and which of them it is; the first of equal ones.
fn least_of(all: impl Iterator<Item = Vec<f32>>) -> (Vec<f32>, Vec<usize>) {
    let (mut values, mut which): (Vec<f32>, Vec<usize>) = Default::default();
    for (member, own) in all.enumerate() {
        if member == 0 {
            which = vec![0; own.len()];
            values = own;
            continue;
        }
        for ((value, which), own) in values.iter_mut().zip(&mut which).zip(own) {
            if own < *value {
                (*value, *which) = (own, member);
            }
        }
    }
    (values, which)
}

/// Returns the least values, and the gradient of their sum by the padded rows: every row has that of its least network.
pub(super) fn gradient(networks: &[CriticNetwork], motion: &PaddedRows, width: usize) -> (Vec<f32>, Vec<f32>) {
    if let [network] = networks {
        return network.gradient(motion, width, &vec![1.0; motion.len()]);
    }
    let (values, which) = least(networks, motion);
    let mut sum: Vec<f32> = Vec::new();
    for (member, network) in networks.iter().enumerate() {
        let share: Vec<f32> = which.iter().map(|least| f32::from(u8::from(*least == member))).collect();
        if share.iter().all(|share| *share == 0.0) {
            continue;
        }
        let (_, by) = network.gradient(motion, width, &share);
        sum.resize(by.len(), 0.0);
        sum.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
    }
    (values, sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_its_own_least_network() {
        let all = [vec![3.0, 1.0, 2.0, 5.0], vec![2.0, 4.0, 2.0, 7.0], vec![9.0, 0.5, 8.0, 6.0]];
        assert_eq!(least_of(all.into_iter()), (vec![2.0, 0.5, 2.0, 5.0], vec![1, 2, 0, 0]));
        assert_eq!(least_of([vec![1.0]].into_iter()), (vec![1.0], vec![0]));
    }
}
