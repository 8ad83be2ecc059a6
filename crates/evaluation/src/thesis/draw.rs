//! Frames that episodes begin at, drawn alike.

use lifelike_robot::ReferenceLibrary;
use rand::Rng;

/// Frames of a library that have at least two frames of their clip after them, numbered clip after clip.
pub(super) struct Frames {
    /// First frame of the library of each clip.
    starts: Vec<usize>,
    /// Number of the first frame of each clip that may be drawn, and how many there are at the end.
    numbers: Vec<usize>,
}

impl Frames {
    pub(super) fn of(library: &ReferenceLibrary) -> Self {
        let (mut starts, mut numbers) = (Vec::new(), vec![0]);
        for clip in 0..library.clips() {
            let range = library.range(clip);
            numbers.push(numbers[clip] + range.len() - 2);
            starts.push(range.start);
        }
        Self { starts, numbers }
    }

    /// Draws any frame.
    pub(super) fn any(&self, rng: &mut impl Rng) -> usize {
        self.frame(rng.random_range(0..self.all()))
    }

    /// Draws a frame of another clip than that of a frame of the library; of the same one where there is no other.
    pub(super) fn elsewhere(&self, frame: usize, rng: &mut impl Rng) -> usize {
        if self.starts.len() < 2 {
            return self.any(rng);
        }
        let clip = self.starts.partition_point(|start| *start <= frame) - 1;
        let (first, end) = (self.numbers[clip], self.numbers[clip + 1]);
        let number = rng.random_range(0..self.all() - (end - first));
        self.frame(if number < first { number } else { number + (end - first) })
    }

    fn all(&self) -> usize {
        self.numbers.last().copied().unwrap_or_default()
    }

    fn frame(&self, number: usize) -> usize {
        let clip = self.numbers.partition_point(|first| *first <= number) - 1;
        self.starts[clip] + number - self.numbers[clip]
    }
}

#[cfg(test)]
mod tests {
    use lifelike_checkpoint::rng::stream;

    use super::*;

    #[test]
    fn frames_are_drawn_alike_and_never_a_clips_last_two() {
        // Clips of 3, 6 and 12 frames: 1, 4 and 10 frames may be drawn.
        let frames = Frames { starts: vec![0, 3, 9], numbers: vec![0, 1, 5, 15] };
        let mut rng = stream(1, "frames", 0, 0);
        let mut counts = [0_u32; 21];
        (0..15_000).for_each(|_| counts[frames.any(&mut rng)] += 1);
        for (frame, count) in counts.iter().enumerate() {
            let allowed = frame == 0 || (3..7).contains(&frame) || (9..19).contains(&frame);
            // 1000 with a standard deviation of 31.
            assert_eq!((850..1150).contains(count), allowed, "frame {frame}: {count}");
            assert!(allowed || *count == 0, "frame {frame}: {count}");
        }
        for own in [0, 5, 20] {
            let clip = |frame: usize| [3, 9].iter().filter(|start| frame >= **start).count();
            assert!((0..2000).map(|_| frames.elsewhere(own, &mut rng)).all(|frame| clip(frame) != clip(own)));
        }
        let alone = Frames { starts: vec![0], numbers: vec![0, 4] };
        assert!((0..100).all(|_| alone.elsewhere(2, &mut rng) < 4));
    }
}
