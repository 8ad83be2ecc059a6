//! Our own container, as a layout among the others.

use super::{Fit, Layout, Part, Rate};
use crate::container;

/// The container.
pub(super) const MOTION: Layout = Layout {
    name: "motion",
    title: "lifelike's motion",
    endings: &[container::EXTENSION],
    rate: Rate::Stated,
    holds: &[Part::Names, Part::Contacts, Part::Origin],
    needs_robot: false,
    // A file begins with the container's header or has another layout, so this is decided before.
    fits: |_, _| Ok(Fit::No),
    read: |_, context| Err(context.expected("lifelike's motion (.motion.safetensors)")),
    write: |clip, _| container::to_bytes(clip),
};
