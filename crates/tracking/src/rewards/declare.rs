//! The macro by which [`terms`](super::terms) declares reward terms, and the kinds of terms.

/// `weight · exp(−sharpness · error)`.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Reward without error.
    #[schemars(extend("unit" = "1"), range(min = -1e6, max = 1e6))]
    pub weight: f32,
    /// Decay with the squared error.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub sharpness: f32,
}

impl Kernel {
    /// Returns the kernel of a weight and a sharpness.
    pub const fn new(weight: f32, sharpness: f32) -> Self {
        Self { weight, sharpness }
    }
}

/// A kind of terms: the settings it has and how they weigh a value in either form.
pub trait TermKind {
    /// Setting in the exponential form.
    type Setting: Copy;
    /// See [`super::Term::penalty`].
    const PENALTY: bool = false;
    /// See [`super::Term::kernel`].
    const KERNEL: bool = false;

    /// Returns the weighted term of the thesis' form.
    fn thesis(weight: f32, value: f32, limit: f32) -> f32;

    /// Returns the weighted term of the exponential form.
    fn exponential(setting: Self::Setting, value: f32) -> f32;
}

/// A squared error, the smaller the better.
pub struct Tracking;

impl TermKind for Tracking {
    type Setting = Kernel;
    const KERNEL: bool = true;

    fn thesis(weight: f32, value: f32, limit: f32) -> f32 {
        -(weight * value).min(limit)
    }

    fn exponential(kernel: Kernel, value: f32) -> f32 {
        kernel.weight * (-kernel.sharpness * value).exp()
    }
}

/// A value, the larger the better.
pub struct Bonus;

impl TermKind for Bonus {
    type Setting = f32;

    fn thesis(weight: f32, value: f32, _limit: f32) -> f32 {
        weight * value
    }

    fn exponential(weight: f32, value: f32) -> f32 {
        weight * value
    }
}

/// A cost of what the body does, at any stage of a curriculum.
pub struct Fault;

impl TermKind for Fault {
    type Setting = f32;

    fn thesis(weight: f32, value: f32, _limit: f32) -> f32 {
        -weight * value
    }

    fn exponential(weight: f32, value: f32) -> f32 {
        -weight * value
    }
}

/// A cost of actions or torques, a sum over joints, which the curriculum of smoothness scales.
pub struct Penalty;

impl TermKind for Penalty {
    type Setting = f32;
    const PENALTY: bool = true;

    fn thesis(weight: f32, value: f32, _limit: f32) -> f32 {
        -weight * value
    }

    fn exponential(weight: f32, value: f32) -> f32 {
        -weight * value
    }
}

/// Reads a limit. The plan in a checkpoint is JSON, which has no infinity and writes null for it.
///
/// # Errors
/// No number.
pub(crate) fn limit<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    let number = <Option<f32> as serde::Deserialize>::deserialize(deserializer)?;
    Ok(number.unwrap_or(f32::INFINITY))
}

/// Puts the units of all weights and kernels into the schema of a form, by the units of [`TERMS`](super::TERMS).
pub(crate) fn put_units(form: &mut schemars::Schema) {
    for term in super::TERMS {
        let property = form.pointer_mut(&format!("/properties/{}", term.name)).and_then(|value| value.as_object_mut());
        let Some(property) = property else { continue };
        if let Some(sharpness) = property.get_mut("properties").and_then(|parts| parts.get_mut("sharpness")) {
            sharpness["unit"] = per(term.unit).into();
            continue;
        }
        // The thesis normalises squared errors.
        property.insert("unit".into(), if term.kernel { "1".into() } else { per(term.unit).into() });
        property.insert("minimum".into(), (-1e6).into());
        property.insert("maximum".into(), 1e6.into());
    }
}

fn per(unit: &str) -> String {
    match unit {
        "" => "1".into(),
        unit if unit.contains([' ', '/']) => format!("1/({unit})"),
        unit => format!("1/{unit}"),
    }
}

/// Declares all terms: the settings of both forms, their values and [`TERMS`](super::TERMS).
///
/// A declaration is `/// meaning`, `name: Kind, "unit" = default in the exponential form { thesis: f, exponential: g }`,
/// with pure functions of [`RewardInputs`](super::RewardInputs). A `#[serde(default)]` before the name makes the term
/// optional in the thesis' form, with weight 0 where a plan does not name it. In the exponential form every term is, with its
/// default.
macro_rules! reward_terms {
    ($(
        $(#[doc = $doc:literal])+
        $(#[serde($serde:ident)])?
        $name:ident: $kind:ident, $unit:literal = $default:expr, { thesis: $thesis:expr, exponential: $exponential:expr }
    )+) => {
        /// The thesis' form: weights of eqs. 4.6-4.8 (Table 4.1), and what makes them learnable with little data.
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[schemars(transform = crate::rewards::declare::put_units)]
        pub struct ThesisReward {
            $(
                $(#[doc = $doc])+
                $(#[serde($serde)])?
                pub $name: f32,
            )+
            /// Factor on the whole reward: brings it near one, which the value function learns sooner.
            #[schemars(extend("unit" = "1"), range(min = -1e6, max = 1e6))]
            pub scale: f32,
            /// Squared norms of eq. 4.6: a sum over components (as written) or their mean.
            #[serde(default)]
            pub norm: Norm,
            /// Largest loss by one tracking term (before `scale`); `inf` is the thesis.
            #[serde(deserialize_with = "crate::rewards::declare::limit")]
            #[schemars(extend("unit" = "1"))]
            pub term_limit: f32,
            /// Smallest standard deviations that errors are divided by.
            pub floors: Floors,
        }

        /// The exponential form. Errors over several joints or sites are MEANS of squares, so the same numbers serve
        /// robots with more or fewer of them.
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        #[schemars(transform = crate::rewards::declare::put_units)]
        pub struct ExponentialReward {
            $(
                $(#[doc = $doc])+
                pub $name: <$kind as TermKind>::Setting,
            )+
            /// Weight of a squared angular velocity error against a linear one (m²).
            #[schemars(extend("unit" = "m²"), range(min = -1e6, max = 1e6))]
            pub angular_share: f32,
        }

        /// All terms, in the order in which they are summed.
        pub const TERMS: &[Term] = &[$(Term {
            name: stringify!($name),
            unit: $unit,
            penalty: <$kind as TermKind>::PENALTY,
            kernel: <$kind as TermKind>::KERNEL,
        }),+];

        impl Default for ExponentialReward {
            fn default() -> Self {
                Self { $($name: $default,)+ angular_share: ANGULAR_SHARE }
            }
        }

        impl ThesisReward {
            pub(super) fn terms(&self, inputs: &RewardInputs<'_>) -> TermValues {
                [$({
                    let value: fn(&RewardInputs<'_>, &Self) -> f32 = $thesis;
                    <$kind as TermKind>::thesis(self.$name, value(inputs, self), self.term_limit) * self.scale
                }),+]
            }
        }

        impl ExponentialReward {
            pub(super) fn terms(&self, inputs: &RewardInputs<'_>) -> TermValues {
                [$({
                    let value: fn(&RewardInputs<'_>, &Self) -> f32 = $exponential;
                    <$kind as TermKind>::exponential(self.$name, value(inputs, self))
                }),+]
            }
        }
    };
}

pub(super) use reward_terms;
