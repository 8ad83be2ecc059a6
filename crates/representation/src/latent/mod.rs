//! Measures of a space of latent codes (thesis 4.3.2): which motion it calls similar, how well it tells motions apart,
//! how much it knows of the motion, and whether the way from one code to another is motion too.
//!
//! The main path: any encoder's output as [`Codes`] → [`lda`] and [`mutual_information`] → [`comparison`] (Table 4.2);
//! [`search`] (Fig. 4.3) and [`probe`] (what a code knows that its frame does not) on the same codes. [`interpolation`] needs a prior's decoder as well; [`unroll`] makes a clip of what
//! it decodes and [`footing`] says how that clip stands on its feet.

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
