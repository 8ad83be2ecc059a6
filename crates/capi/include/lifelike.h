#ifndef LIFELIKE_H
#define LIFELIKE_H

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/*
 A policy with its robot.
 */
typedef struct LifelikeController LifelikeController;

/*
 Motion to follow.
 */
typedef struct LifelikeReference LifelikeReference;

/*
 One robot's run of a controller.
 */
typedef struct LifelikeRun LifelikeRun;

/*
 A robot as its sensors tell. Null: not measured.
 */
typedef struct LifelikeMeasured {
  /*
   Joint positions (rad), one for each joint.
   */
  const float *joint_position;
  /*
   Joint velocities (rad/s), one for each joint.
   */
  const float *joint_velocity;
  /*
   Orientation of the root (wxyz).
   */
  float root_orientation[4];
  /*
   Angular velocity of the root (rad/s, in its own frame, as a gyroscope gives it).
   */
  float angular_velocity_b[3];
  /*
   Position of the root (m, world), 3 numbers or null.
   */
  const float *root_position;
  /*
   Linear velocity of the root (m/s, world), 3 numbers or null.
   */
  const float *linear_velocity_w;
} LifelikeMeasured;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Returns the sentence of this thread's last failure; valid until the next one.
 */
const char *lifelike_error(void);

/*
 Loads a controller for a robot: a name (lima, humanoid, g1), or an MJCF or URDF file. Null on failure.

 # Safety
 Both are texts that end with zero.
 */
struct LifelikeController *lifelike_controller_load(const char *path, const char *robot);

/*
 Frees a controller. Runs of it go on.

 # Safety
 `controller` came from `lifelike_controller_load` and was not freed, or is null.
 */
void lifelike_controller_free(struct LifelikeController *controller);

/*
 Returns the number of joints; 0 for null.

 # Safety
 `controller` is alive, or null.
 */
uintptr_t lifelike_joints(const struct LifelikeController *controller);

/*
 Returns the name of a joint, valid as long as the controller; null where there is no such joint.

 # Safety
 `controller` is alive.
 */
const char *lifelike_joint_name(const struct LifelikeController *controller, uintptr_t joint);

/*
 Returns the steps per second; below 0 on failure.

 # Safety
 `controller` is alive.
 */
double lifelike_rate(const struct LifelikeController *controller);

/*
 Writes default pose (rad), stiffness (N m/rad) and damping (N m s/rad) of every joint; null: not wanted. 0, or below on failure.

 # Safety
 `controller` is alive; each array has one number for each joint.
 */
int32_t lifelike_gains(const struct LifelikeController *controller,
                       float *default_pose,
                       float *kp,
                       float *kd);

/*
 Loads a clip of the controller's robot. Null on failure.

 # Safety
 `controller` is alive; `path` is a text that ends with zero.
 */
struct LifelikeReference *lifelike_reference_load(const struct LifelikeController *controller, const char *path);

/*
 Makes a reference of frames: root positions (m, 3 each), root orientations (wxyz, 4 each), joints (rad, one for each
 joint in the controller's order). Null on failure.

 # Safety
 `controller` is alive; the arrays have as many numbers as said.
 */
struct LifelikeReference *lifelike_reference_from_frames(const struct LifelikeController *controller,
                                                         double frames_per_second,
                                                         uintptr_t frames,
                                                         const float *root_position,
                                                         const float *root_orientation,
                                                         const float *joints);

/*
 Returns the frames of a reference at the controller's rate; 0 for null.

 # Safety
 `reference` is alive, or null.
 */
uintptr_t lifelike_frames(const struct LifelikeReference *reference);

/*
 Frees a reference. Runs of it go on.

 # Safety
 `reference` came from a function here and was not freed, or is null.
 */
void lifelike_reference_free(struct LifelikeReference *reference);

/*
 Begins a run at the reference's first frame. Null on failure.

 # Safety
 Both are alive.
 */
struct LifelikeRun *lifelike_run_new(const struct LifelikeController *controller,
                                     const struct LifelikeReference *reference);

/*
 One step: writes a joint target (rad) for each joint, and the reference goes on by a frame. 0, or below on failure.

 # Safety
 `run` and `measured` are alive; `targets` has room for `count` numbers.
 */
int32_t lifelike_step(struct LifelikeRun *run,
                      const struct LifelikeMeasured *measured,
                      float *targets,
                      uintptr_t count);

/*
 Frees a run.

 # Safety
 `run` came from `lifelike_run_new` and was not freed, or is null.
 */
void lifelike_run_free(struct LifelikeRun *run);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LIFELIKE_H */
