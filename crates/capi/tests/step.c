/* A controller in C: it stands on its reference for a second, and prints its last targets. Compiles as C11 and as C++17. */
#include "lifelike.h"

#include <stdio.h>
#include <stdlib.h>

static int failed(const char *what) {
    fprintf(stderr, "%s: %s\n", what, lifelike_error());
    return 1;
}

int main(int count, char **arguments) {
    if (count != 3) return 2;
    if (lifelike_controller_load("nowhere.controller.safetensors", "lima")) return 3;
    fprintf(stderr, "expected failure: %s\n", lifelike_error());

    struct LifelikeController *controller = lifelike_controller_load(arguments[1], arguments[2]);
    if (!controller) return failed("controller");
    const size_t joints = lifelike_joints(controller);
    float *pose = (float *)calloc(joints, sizeof(float)), *still = (float *)calloc(joints, sizeof(float));
    float *targets = (float *)calloc(joints, sizeof(float));
    if (lifelike_gains(controller, pose, NULL, NULL)) return failed("gains");

    /* A reference of fifty frames in the default pose. */
    const size_t frames = 50;
    float *places = (float *)calloc(3 * frames, sizeof(float)), *turns = (float *)calloc(4 * frames, sizeof(float));
    float *angles = (float *)calloc(joints * frames, sizeof(float));
    for (size_t t = 0; t < frames; ++t) {
        places[3 * t + 2] = 0.4f;
        turns[4 * t] = 1.0f;
        for (size_t j = 0; j < joints; ++j) angles[t * joints + j] = pose[j];
    }
    struct LifelikeReference *reference = lifelike_reference_from_frames(controller, 50.0, frames, places, turns, angles);
    if (!reference) return failed("reference");
    struct LifelikeRun *run = lifelike_run_new(controller, reference);
    if (!run) return failed("run");
    lifelike_reference_free(reference);

    const float root[3] = {0.0f, 0.0f, 0.4f};
    struct LifelikeMeasured measured = {pose, still, {1.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, root, still};
    for (size_t t = 0; t < frames; ++t)
        if (lifelike_step(run, &measured, targets, joints)) return failed("step");
    if (lifelike_step(run, &measured, targets, joints - 1) == 0) return 4;
    for (size_t j = 0; j < joints; ++j) printf("%s %.9g\n", lifelike_joint_name(controller, j), targets[j]);
    lifelike_run_free(run);
    lifelike_controller_free(controller);
    free(pose); free(still); free(targets); free(places); free(turns); free(angles);
    return 0;
}
