//! Floor 2: motion with words.
