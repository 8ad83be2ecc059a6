//! Measures of a space of latent codes (thesis 4.3.2): similarity, class separation, information about the motion, and
//! interpolation.
//!
//! The main path: any encoder's output as [`Codes`] → [`lda`] and [`mutual_information`] → [`comparison`] (Table 4.2).
//! [`search`] (Fig. 4.3) and [`probe`] (information beyond the frame) use the same codes. [`interpolation`] also needs
//! a prior's decoder; [`unroll`] turns its output into a clip and [`footing`] measures the clip's ground contact.

pub mod codes;
pub mod comparison;
pub mod footing;
pub mod interpolation;
pub mod lda;
pub mod mutual_information;
pub mod probe;
pub mod search;
pub mod unroll;

pub use codes::Codes;
pub use comparison::{Encoded, LatentScore};
