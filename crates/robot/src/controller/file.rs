//! A controller as one file (`*.controller.safetensors`).

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use sha2::{Digest, Sha256};

use super::description::RobotDescription;
use super::golden;
use super::header::ControllerHeader;
use super::policy::FrozenPolicy;
use super::prior::PriorEncoder;
use crate::robot::Robot;
use crate::{FromInput, RobotError};

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
    robot: RobotDescription,
}

impl ControllerFile {
    /// Makes a controller for a robot of the arrays of a policy (`actor.*`, `normalizer.*`, as `save` writes them) and
    /// the encoder of its latent codes. Without the encoder it follows references that bring their codes.
    ///
    /// # Errors
    /// Header, arrays, encoder and robot do not fit each other.
    pub fn new(
        mut header: ControllerHeader,
        arrays: &Checkpoint,
        prior: Option<PriorEncoder>,
        robot: &Robot,
    ) -> Result<Self, RobotError> {
        header.observation.check_sizes()?;
        let prior = prior.filter(|_| header.observation.reference.latent > 0);
        header.parts = ControllerHeader::parts_of(&header.observation);
        header.prior = prior.as_ref().map(|prior| prior.header().clone());
        header.check()?;
        let policy = FrozenPolicy::load(arrays, &header)?;
        header.provenance.policy = sha256(&policy)?;
        Self::assemble(header, policy, prior, RobotDescription::of(robot))
    }

    fn assemble(
        header: ControllerHeader,
        policy: FrozenPolicy,
        prior: Option<PriorEncoder>,
        robot: RobotDescription,
    ) -> Result<Self, RobotError> {
        if let Some(prior) = &prior {
            let (of, spec) = (prior.header(), &header.observation);
            let mismatch = |what: &str, expected: String, got: String| {
                Err(RobotError::mismatch(format!("{what} of the controller's motion prior"), expected, got))
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

    /// Reads a controller.
    ///
    /// # Errors
    /// The file is damaged or no controller, or its golden vectors are not reproduced.
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        Self::from_checkpoint(&Checkpoint::load(path)?, &path.display().to_string())
    }

    /// Reads a controller from a file's content; `path` is for messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_checkpoint(file: &Checkpoint, path: &str) -> Result<Self, RobotError> {
        if !file.metadata().contains_key(KIND) {
            let expected = format!("a controller (a file with the header '{KIND}')");
            return Err(RobotError::mismatch(path, expected, "another file"));
        }
        let header: ControllerHeader = file.meta(KIND)?;
        header.check()?;
        let policy = FrozenPolicy::load(file, &header)?;
        let prior = header.prior.clone().map(|prior| PriorEncoder::load(file, prior)).transpose()?;
        golden::replay(&policy, prior.as_ref(), file, path)?;
        let robot = RobotDescription::load(file)?;
        if robot.joints != header.observation.joints {
            let expected = header.observation.joints.join(", ");
            return Err(RobotError::mismatch(
                format!("{path}: joints of the robot"),
                expected,
                robot.joints.join(", "),
            ));
        }
        Self::assemble(header, policy, prior, robot)
    }

    /// Checks that the controller makes its latent codes itself, where its policy sees any.
    ///
    /// # Errors
    /// The motion prior's encoder is not in the file.
    pub fn check_complete(&self) -> Result<(), RobotError> {
        let wanted = self.header.observation.reference.latent;
        if wanted == 0 || self.prior.is_some() {
            return Ok(());
        }
        let expected = format!("an encoder of the {wanted} latent numbers that the policy wants");
        let got = "none: encoders of spline priors run beside a controller only, not in it";
        Err(RobotError::mismatch("motion prior in the controller's file", expected, got))
    }

    /// Returns the file's content.
    ///
    /// # Errors
    /// Never for a controller that was read or made.
    pub fn to_checkpoint(&self) -> Result<Checkpoint, RobotError> {
        let mut file = Checkpoint::new();
        file.set_meta(KIND, &self.header)?;
        self.policy.save_into(&mut file)?;
        if let Some(prior) = &self.prior {
            prior.save_into(&mut file)?;
        }
        self.robot.save_into(&mut file)?;
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
        self.header.check_robot(robot)?;
        self.robot.check(robot)
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

    /// The robot that it was made for.
    pub fn robot(&self) -> &RobotDescription {
        &self.robot
    }
}

/// SHA-256 of a policy's arrays as a file has them, hexadecimal.
fn sha256(policy: &FrozenPolicy) -> Result<String, RobotError> {
    let mut arrays = Checkpoint::new();
    policy.save_into(&mut arrays)?;
    Ok(Sha256::digest(arrays.to_bytes()?).iter().map(|b| format!("{b:02x}")).collect())
}
