"""Where episodes begin: anywhere in the clip, or more often before the places where the policy fails."""

import numpy as np


class Starts:
    """Failure statistics over stretches of half a second."""

    def __init__(self, frames: int, bin_frames: int, share: float, floor: float = 0.02, memory: float = 0.98):
        self.bin_frames, self.share, self.floor, self.memory = bin_frames, share, floor, memory
        # No episode begins in the last second of the clip.
        allowed_end = max(frames - 2 * bin_frames, 1)
        self.first = np.arange(0, frames, bin_frames)
        self.allowed = np.clip(allowed_end - self.first, 0, bin_frames)
        self.visits, self.failures = np.zeros(len(self.first)), np.zeros(len(self.first))
        self.refresh()

    def record(self, begin: int, end: int, failed: bool):
        """An episode ran from frame to frame, and failed at the last one or did not."""
        a, b = begin // self.bin_frames, end // self.bin_frames
        self.visits[a : b + 1] += 1
        self.failures[b] += failed

    def refresh(self):
        """Once per iteration: forgets a little, and puts new weights into force."""
        self.visits *= self.memory
        self.failures *= self.memory
        known = self.visits > 0.5
        rate = np.maximum(np.where(known, self.failures / np.maximum(self.visits, 0.5), 0), self.floor)
        # What goes wrong in a stretch was often begun in the one before it.
        hard = self.allowed * (rate + 0.5 * np.append(rate[1:], 0))
        even = self.allowed / self.allowed.sum()
        self.cumulative = np.cumsum((1 - self.share) * even + self.share * hard / hard.sum())

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """Frames to begin at."""
        at = rng.random(n) * self.cumulative[-1]
        bins = np.minimum(np.searchsorted(self.cumulative, at, side="right"), len(self.first) - 1)
        return self.first[bins] + rng.integers(0, np.maximum(self.allowed[bins], 1))
