//! Floor 4: learning. `representation` (the motion prior) ← `tracking` (PPO) with `evaluation` beside them.
