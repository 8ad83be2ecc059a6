//! The list of kinds of motion priors, at the end of this file: a kind is a folder that implements [`PriorKind`] and
//! one line there.

use std::path::PathBuf;

use lifelike_checkpoint::Checkpoint;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kind::{KindPlan, PriorData, PriorKind, WithTrainer};
use super::spline::SplineCoder;
use super::vae::{MotionVae, VaePlan};
use super::window_plan::WindowPlan;
use crate::RepresentationError;
use crate::components::Components;

/// Writes [`PriorPlan`] and [`Coder`], one variant for each kind, and passes their calls on.
macro_rules! kinds {
    ($($(#[$doc:meta])* $variant:ident: $kind:ty, $table:ident;)+) => {
        /// Plan of a motion prior: which kind it is, and its settings.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        #[serde(untagged)]
        pub enum PriorPlan {
            $($(#[$doc])* $variant(<$kind as PriorKind>::Plan),)+
        }

        impl PriorPlan {
            /// Returns the `kind` of the file of such a prior.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => <$kind>::NAME,)+
                }
            }

            /// Windows to train on and to encode.
            pub fn windows(&self) -> &WindowPlan {
                match self {
                    $(Self::$variant(plan) => plan.windows(),)+
                }
            }

            /// Returns d_z.
            pub fn latent_size(&self) -> usize {
                match self {
                    $(Self::$variant(plan) => plan.latent_size(),)+
                }
            }

            /// Names the numbers of a code, for people.
            pub fn describe_code(&self) -> String {
                match self {
                    $(Self::$variant(plan) => plan.describe_code(),)+
                }
            }

            /// Checks every range.
            ///
            /// # Errors
            /// The first key out of range.
            pub fn check(&self) -> Result<(), RepresentationError> {
                match self {
                    $(Self::$variant(plan) => plan.check(),)+
                }
            }

            /// Begins a training and hands it to `with`.
            ///
            /// # Errors
            /// A plan out of range, no training frames, or a clip that does not fit the layout.
            pub fn train<W: WithTrainer>(
                &self,
                data: PriorData,
                with: W,
            ) -> Result<W::Output, RepresentationError> {
                match self {
                    $(Self::$variant(plan) => Ok(with.run(<$kind as PriorKind>::trainer(plan, data)?)),)+
                }
            }

            /// Returns whether a file's `kind` is that of a prior.
            pub(super) fn is_kind(kind: &str) -> bool {
                [$(<$kind>::NAME),+].contains(&kind)
            }

            /// Reads the plan of a prior's file; none where the file's `kind` is no prior's.
            pub(super) fn load_from(checkpoint: &Checkpoint, kind: &str) -> Result<Option<Self>, RepresentationError> {
                $(if kind == <$kind>::NAME {
                    let plan: <$kind as PriorKind>::Plan = checkpoint.meta("plan")?;
                    plan.check()?;
                    return Ok(Some(Self::$variant(plan)));
                })+
                Ok(None)
            }
        }

        /// A training run of a motion prior, as its TOML file has it: one table chooses the kind.
        #[derive(Default, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(super) struct Written {
            /// Robot: a built-in name, or an MJCF or URDF file.
            pub robot: String,
            /// Clips to train on: files, folders, patterns.
            ///
            /// Captured motion and keyframes are retargeted to the robot.
            pub clips: Vec<PathBuf>,
            /// Learning from the mirror image of every training clip too, by the robot's own symmetry.
            #[serde(default)]
            pub mirror: bool,
            /// Clips that only measure the reconstruction, in place of the share `held_out`.
            ///
            /// They and others of their names are never trained on.
            #[serde(default)]
            pub validation: Vec<PathBuf>,
            $(
                $(#[$doc])*
                #[serde(default, skip_serializing_if = "Option::is_none")]
                $table: Option<<$kind as PriorKind>::Plan>,
            )+
        }

        impl Written {
            /// Takes the prior out of the table of its kind; without any it is a β-VAE with all defaults.
            pub(super) fn take_prior(&mut self) -> Result<PriorPlan, String> {
                let tables = [$(self.$table.take().map(PriorPlan::from)),+];
                let mut chosen = tables.into_iter().flatten();
                let prior = chosen.next().unwrap_or_else(|| VaePlan::default().into());
                if chosen.next().is_some() {
                    let tables = [$(format!("[{}] ({})", stringify!($table), <$kind>::TITLE)),+].join(", ");
                    return Err(format!("expected one table of {tables}, got two"));
                }
                Ok(prior)
            }

            /// Returns a run with a prior in the table of its kind, and all else empty.
            pub(super) fn with_prior(prior: PriorPlan) -> Self {
                let mut written = Self::default();
                match prior {
                    $(PriorPlan::$variant(plan) => written.$table = Some(plan),)+
                }
                written
            }
        }

        /// Encoder and decoder of any kind.
        #[derive(Debug, Clone)]
        pub(super) enum Coder {
            $($variant(Box<$kind>),)+
        }

        impl Coder {
            /// As [`PriorKind::encode`].
            pub(super) fn encode(&self, windows: Vec<f32>, shape: [usize; 2]) -> Result<Vec<f32>, RepresentationError> {
                match self {
                    $(Self::$variant(coder) => <$kind as PriorKind>::encode(coder, windows, shape),)+
                }
            }

            /// As [`PriorKind::decode`].
            pub(super) fn decode(&self, codes: &[f32], samples: usize) -> Result<Vec<f32>, RepresentationError> {
                match self {
                    $(Self::$variant(coder) => <$kind as PriorKind>::decode(coder, codes, samples),)+
                }
            }

            /// As [`PriorKind::save_into`].
            pub(super) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
                match self {
                    $(Self::$variant(coder) => <$kind as PriorKind>::save_into(coder, checkpoint),)+
                }
            }

            /// As [`PriorKind::load_from`].
            pub(super) fn load_from(
                plan: &PriorPlan,
                checkpoint: &Checkpoint,
                features: usize,
            ) -> Result<Self, RepresentationError> {
                match plan {
                    $(PriorPlan::$variant(plan) => {
                        Ok(Self::$variant(Box::new(<$kind as PriorKind>::load_from(plan, checkpoint, features)?)))
                    })+
                }
            }
        }

        $(impl From<<$kind as PriorKind>::Plan> for PriorPlan {
            fn from(plan: <$kind as PriorKind>::Plan) -> Self {
                Self::$variant(plan)
            }
        }

        impl From<$kind> for Coder {
            fn from(coder: $kind) -> Self {
                Self::$variant(Box::new(coder))
            }
        })+
    };
}

kinds! {
    /// The convolutional β-VAE of thesis 4.2.1.
    Vae: MotionVae, prior;
    /// The Spline-based Transformer of chapter 3.
    Spline: SplineCoder, spline;
    /// Principal components, the plain baseline.
    Pca: Components, pca;
}
