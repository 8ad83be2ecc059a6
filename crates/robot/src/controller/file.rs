//! A controller as one file (`*.controller.safetensors`).

use std::path::Path;

use lifelike_checkpoint::Checkpoint;

use super::description::RobotDescription;
use super::golden;
use super::header::ControllerHeader;
use super::policy::FrozenPolicy;
use super::policy_file::{POLICY, sha256};
use super::prior::PriorEncoder;
use crate::error::RobotError;
use crate::robot::Robot;

/// Ending of the names of controller files.
pub const EXTENSION: &str = ".controller.safetensors";
/// `kind` of a controller's file.
pub const KIND: &str = "controller";

/// Networks, names and numbers of a controller, apart from any robot.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerFile {
    header: ControllerHeader,
    policy: FrozenPolicy,
    prior: Option<PriorEncoder>,
    /// Not in policies of before there were controllers.
    robot: Option<RobotDescription>,
}

impl ControllerFile {
    pub(super) fn assemble(
        header: ControllerHeader,
        policy: FrozenPolicy,
        prior: Option<PriorEncoder>,
        robot: Option<RobotDescription>,
    ) -> Result<Self, RobotError> {
        if let Some(prior) = &prior {
            let (of, spec) = (prior.header(), &header.observation);
            let mismatch = |what: &str, expected: String, got: String| {
                Err(RobotError::Mismatch { what: format!("{what} of the controller's motion prior"), expected, got })
            };
            if of.latent != spec.reference.latent {
                return mismatch("size of the latent code", spec.reference.latent.to_string(), of.latent.to_string());
            }
            if of.layout.joints != spec.joints || of.layout.end_effectors != spec.end_effectors {
                let names = |joints: &[String], effectors: &[String]| {
                    format!("{} and {}", joints.join(", "), effectors.join(", "))
                };
                let expected = names(&spec.joints, &spec.end_effectors);
                return mismatch(
                    "joints and end effectors",
                    expected,
                    names(&of.layout.joints, &of.layout.end_effectors),
                );
            }
            if (of.frame_rate - header.control_hz).abs() > 1e-9 {
                return mismatch("frame rate (Hz)", header.control_hz.to_string(), of.frame_rate.to_string());
            }
        }
        Ok(Self { header, policy, prior, robot })
    }

    /// Reads a controller, or a policy without its prior, which then follows references that bring their latent codes.
    ///
    /// # Errors
    /// The file is damaged or neither, or its golden vectors are not reproduced.
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        Self::joined(path, None)
    }

    /// Reads a controller, or a policy with the prior that it wants.
    ///
    /// # Errors
    /// As [`Self::read`]; a prior is missing or another one.
    pub fn load(path: &Path, prior: Option<&Path>) -> Result<Self, RobotError> {
        let prior = prior.map(read).transpose()?;
        let controller = Self::joined(path, prior.as_ref().map(|(file, _)| file))?;
        let wanted = &controller.header.provenance.prior;
        if controller.header.observation.reference.latent > 0 && controller.robot.is_none() {
            let got =
                prior.map_or_else(|| "none: name its file".to_string(), |(_, digest)| format!("SHA-256 {digest}"));
            if !(got.ends_with(wanted.as_str()) && controller.prior.is_some()) {
                return Err(RobotError::Mismatch {
                    what: format!("{}: motion prior that the policy was trained with", path.display()),
                    expected: format!("SHA-256 {wanted}"),
                    got,
                });
            }
        }
        Ok(controller)
    }

    fn joined(path: &Path, prior: Option<&Checkpoint>) -> Result<Self, RobotError> {
        let (file, digest) = read(path)?;
        if file.metadata().contains_key(KIND) {
            return Self::from_checkpoint(&file, &path.display().to_string());
        }
        if !file.metadata().contains_key(POLICY) {
            return Err(RobotError::Mismatch {
                what: path.display().to_string(),
                expected: "a controller or a policy".into(),
                got: "neither: no such header".into(),
            });
        }
        Self::join(&file, prior, digest)
    }

    /// Reads a controller from a file's content; `path` is for messages.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_checkpoint(file: &Checkpoint, path: &str) -> Result<Self, RobotError> {
        let header: ControllerHeader = file.meta(KIND)?;
        header.check()?;
        let policy = FrozenPolicy::load(file, &header)?;
        let prior = header.prior.clone().map(|prior| PriorEncoder::load(file, prior)).transpose()?;
        golden::replay(&policy, prior.as_ref(), file, path)?;
        let robot = RobotDescription::load(file)?;
        if robot.joints != header.observation.joints {
            return Err(RobotError::Mismatch {
                what: format!("{path}: joints of the robot"),
                expected: header.observation.joints.join(", "),
                got: robot.joints.join(", "),
            });
        }
        Self::assemble(header, policy, prior, Some(robot))
    }

    /// The file's content for a robot that it fits.
    ///
    /// # Errors
    /// The policy wants latent codes and there is no encoder of them.
    pub fn to_checkpoint(&self, robot: &Robot) -> Result<Checkpoint, RobotError> {
        let wanted = self.header.observation.reference.latent;
        if wanted > 0 && self.prior.is_none() {
            return Err(RobotError::Mismatch {
                what: "controller to write".into(),
                expected: format!(
                    "an encoder of the {wanted} latent numbers that the policy wants: name its motion prior"
                ),
                got: "none".into(),
            });
        }
        let mut file = Checkpoint::new();
        file.set_meta(KIND, &self.header)?;
        self.policy.save_into(&mut file)?;
        if let Some(prior) = &self.prior {
            prior.save_into(&mut file)?;
        }
        RobotDescription::of(robot).save_into(&mut file)?;
        golden::record(&self.policy, self.prior.as_ref(), &mut file)?;
        Ok(file)
    }

    /// Returns the controller with the plan of the environment that it was trained in (TOML).
    ///
    /// # Errors
    /// The plan is longer than [`ControllerHeader::MAX_ENVIRONMENT`].
    pub fn trained_in(mut self, environment: String) -> Result<Self, RobotError> {
        self.header.environment = Some(environment);
        self.header.check()?;
        Ok(self)
    }

    /// Checks that it may drive a robot.
    ///
    /// # Errors
    /// Names, order, default pose, rate, gains or limits are others.
    pub fn check(&self, robot: &Robot) -> Result<(), RobotError> {
        self.check_robot(robot)?;
        self.header.observation.check(robot)?;
        if self.header.control_hz != robot.control_hz {
            return Err(RobotError::Mismatch {
                what: format!("policy rate for robot '{}' (Hz)", robot.name),
                expected: self.header.control_hz.to_string(),
                got: robot.control_hz.to_string(),
            });
        }
        self.robot.as_ref().map_or(Ok(()), |description| description.check(robot))
    }

    /// Checks that it was made for a robot with these joints, in whatever order.
    fn check_robot(&self, robot: &Robot) -> Result<(), RobotError> {
        let (own, others) = (&self.header.observation.joints, &robot.layout.joints);
        let beside = |joints: &[String], others: &[String]| {
            joints.iter().find(|joint| !others.contains(joint)).map(|first| format!(", one of them '{first}'"))
        };
        let (of_policy, of_robot) = (beside(own, others), beside(others, own));
        if of_policy.is_none() && of_robot.is_none() {
            return Ok(());
        }
        Err(RobotError::OtherRobot {
            policy: self.header.robot.clone(),
            joints: format!("{} joints{}", own.len(), of_policy.unwrap_or_default()),
            robot: robot.name.clone(),
            robot_joints: format!("{}{}", others.len(), of_robot.unwrap_or_default()),
        })
    }

    /// Names, layout and provenance.
    pub fn header(&self) -> &ControllerHeader {
        &self.header
    }

    /// The frozen policy.
    pub fn policy(&self) -> &FrozenPolicy {
        &self.policy
    }

    /// The frozen encoder of latent codes, where it has one.
    pub fn prior(&self) -> Option<&PriorEncoder> {
        self.prior.as_ref()
    }

    /// The robot that it was made for; not known of policies of before there were controllers.
    pub fn robot(&self) -> Option<&RobotDescription> {
        self.robot.as_ref()
    }
}

/// A file and its SHA-256.
fn read(path: &Path) -> Result<(Checkpoint, String), RobotError> {
    let bytes = std::fs::read(path).map_err(|source| RobotError::Io { path: path.into(), source })?;
    Ok((Checkpoint::from_bytes(&bytes, path)?, sha256(&bytes)))
}
