//! The motion that came of an episode, as a clip.

use lifelike_motion::{MotionClip, Provenance};

use super::rollout::Rollout;

impl Rollout {
    /// Returns what physics made of the clip: all recorded frames, those after a fall too. This is the projection of
    /// PhysDiff (Yuan et al. 2023) onto what a controller can do, without forces from nowhere.
    pub fn played(&self, provenance: Provenance) -> MotionClip {
        MotionClip {
            name: self.clip.clone(),
            fps: self.fps,
            joint_names: self.names.joints.clone(),
            root_position: self.simulated.iter().map(|frame| frame.root_position).collect(),
            root_orientation: self.simulated.iter().map(|frame| frame.root_orientation).collect(),
            joints: self.simulated.iter().flat_map(|frame| frame.joints.iter().copied()).collect(),
            contacts: None,
            cyclic: false,
            provenance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rollout::example::{rollout, snapshot};
    use lifelike_character::Vec3;
    use lifelike_motion::Provenance;

    #[test]
    fn every_recorded_frame_is_in_the_clip() {
        let r = rollout(4, |_| snapshot(Vec3::z(), 0.0, 0.0), |t| snapshot(Vec3::new(t, 0.0, 1.0), t, 2.0 * t));
        let clip = r.played(Provenance::default());
        assert_eq!((clip.name.as_str(), clip.len(), clip.fps), ("walk", 4, 10.0));
        assert_eq!(clip.root_position[3], Vec3::new(0.3, 0.0, 1.0));
        assert_eq!(clip.joints_at(2), [0.4]);
    }
}
