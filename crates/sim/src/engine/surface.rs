//! Stiffness and friction of contacts: MuJoCo's contact parameters and their mixing rules.

use lifelike_character::Geom;

use super::lanes::{Lanes, Scalar};

/// MuJoCo's defaults.
pub const SOLREF: [f64; 2] = [0.02, 1.0];
pub const SOLIMP: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];

/// Softness of a constraint: MuJoCo's `solref` and `solimp` in the numbers that a step needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softness<T> {
    /// Stiffness of the reference acceleration (1/s²).
    pub stiffness: T,
    /// Its damping (1/s).
    pub damping: T,
    low: T,
    span: T,
    inverse_width: T,
    middle: T,
    power: T,
    /// Factors of the two halves of the ramp.
    rising: T,
    falling: T,
    ramp: Ramp,
}

/// Growth of the impedance with the violation.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ramp {
    Flat,
    Linear,
    Square,
    Power,
}

impl<T: Scalar> Softness<T> {
    /// MuJoCo's `mj_makeImpedance`, for both meanings of `solref`; time constants are kept above two time steps.
    pub fn new(solref: [f64; 2], solimp: [f64; 5], timestep: f64) -> Self {
        let clamp = |x: f64| x.clamp(1e-4, 0.9999);
        let (low, high) = (clamp(solimp[0]), clamp(solimp[1]));
        let (width, middle, power) = (solimp[2].max(0.0), clamp(solimp[3]), solimp[4].max(1.0));
        let (stiffness, damping) = if solref[0] > 0.0 {
            let (time, ratio) = (solref[0].max(2.0 * timestep), solref[1]);
            (1.0 / (high * high * time * time * ratio * ratio).max(1e-15), 2.0 / (high * time).max(1e-15))
        } else {
            (-solref[0] / (high * high).max(1e-15), -solref[1] / high.max(1e-15))
        };
        let flat = width < 1e-15 || low == high;
        Self {
            stiffness: T::new(stiffness),
            damping: T::new(damping),
            low: T::new(if flat { 0.5 * (low + high) } else { low }),
            span: T::new(high - low),
            inverse_width: T::new(1.0 / width.max(1e-15)),
            middle: T::new(middle),
            power: T::new(power),
            rising: T::new(middle.powf(1.0 - power)),
            falling: T::new((1.0 - middle).powf(1.0 - power)),
            ramp: match power {
                _ if flat => Ramp::Flat,
                1.0 => Ramp::Linear,
                2.0 => Ramp::Square,
                _ => Ramp::Power,
            },
        }
    }

    /// Returns the impedance of a violation (m or rad).
    #[inline(always)]
    pub fn impedance<V: Lanes<Scalar = T>>(&self, violation: V) -> V {
        let (low, one) = (V::splat(self.low), V::splat_f64(1.0));
        let x = (violation.abs() * V::splat(self.inverse_width)).min(one);
        let rest = one - x;
        let (rising, falling) = match self.ramp {
            Ramp::Flat => return low,
            Ramp::Linear => return low.add_mul(x, V::splat(self.span)),
            Ramp::Square => (x * x, rest * rest),
            Ramp::Power => {
                let power = self.power.to_f64();
                (x.map(|x| T::new(x.to_f64().powf(power))), rest.map(|x| T::new(x.to_f64().powf(power))))
            }
        };
        let (rising, falling) = (rising * V::splat(self.rising), one.sub_mul(falling, V::splat(self.falling)));
        low.add_mul(x.select_gt(V::splat(self.middle), falling, rising), V::splat(self.span))
    }
}

/// Returns the regularization R = (1 - i) / i · Â of a constraint of this impedance.
#[inline(always)]
pub fn regularization<V: Lanes>(impedance: V, weight: V) -> V {
    ((V::splat_f64(1.0) - impedance) / impedance * weight).max(V::splat_f64(1e-15))
}

/// Contact properties of a geom.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    contype: u32,
    conaffinity: u32,
    condim: u32,
    friction: f64,
    solref: [f64; 2],
    solimp: [f64; 5],
    margin: f64,
    priority: i32,
}

/// A contact's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mixed<T> {
    pub friction: T,
    /// Frictionless (`condim` 1).
    pub smooth: bool,
    pub softness: Softness<T>,
    /// Distance below which a force can act (m): both margins, as MuJoCo adds them since 3.12; a gap only finds contacts earlier.
    pub margin: T,
}

impl Surface {
    /// Those of a geom.
    pub fn of(geom: &Geom) -> Self {
        Self {
            contype: geom.contype,
            conaffinity: geom.conaffinity,
            condim: geom.condim,
            friction: geom.friction[0],
            solref: geom.solref,
            solimp: geom.solimp,
            margin: geom.margin,
            priority: geom.priority,
        }
    }

    /// Those of MuJoCo's default geom: the ground that a robot without one stands on.
    pub fn default_ground() -> Self {
        Self {
            contype: 1,
            conaffinity: 1,
            condim: 3,
            friction: 1.0,
            solref: SOLREF,
            solimp: SOLIMP,
            margin: 0.0,
            priority: 0,
        }
    }

    /// MuJoCo's filter.
    pub fn can_collide(&self, other: &Self) -> bool {
        self.contype & other.conaffinity != 0 || other.contype & self.conaffinity != 0
    }

    /// Parameters of a contact (`mj_contactParam`): of the one with the higher priority, else mixed.
    pub fn mix<T: Scalar>(&self, other: &Self, timestep: f64) -> Mixed<T> {
        let pick = |own: f64, their: f64, both: f64| match self.priority.cmp(&other.priority) {
            std::cmp::Ordering::Greater => own,
            std::cmp::Ordering::Less => their,
            std::cmp::Ordering::Equal => both,
        };
        let solref = std::array::from_fn(|i| {
            let (a, b) = (self.solref[i], other.solref[i]);
            let mixed = if self.solref[0] > 0.0 && other.solref[0] > 0.0 { 0.5 * (a + b) } else { a.min(b) };
            pick(a, b, mixed)
        });
        let solimp = std::array::from_fn(|i| {
            let (a, b) = (self.solimp[i], other.solimp[i]);
            pick(a, b, 0.5 * (a + b))
        });
        let condim = pick(self.condim.into(), other.condim.into(), self.condim.max(other.condim).into());
        Mixed {
            friction: T::new(pick(self.friction, other.friction, self.friction.max(other.friction))),
            smooth: condim < 2.0,
            softness: Softness::new(solref, solimp, timestep),
            margin: T::new(self.margin + other.margin),
        }
    }
}
