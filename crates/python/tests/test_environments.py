"""The environments of training, by themselves, in gymnasium and in rsl_rl."""

import gymnasium
import lifelike
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_action_space, check_observation_space, check_space_limit, data_equivalence
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import ClipAction, NormalizeReward, RecordEpisodeStatistics

import lifelike.gymnasium

SHORT = {"changes": ["episode.seconds=0.2"]}


def make(num_envs=16, **arguments):
    return gymnasium.make_vec("lifelike/Tracking-v0", num_envs=num_envs, **arguments)


def test_a_seed_determines_everything_and_threads_nothing():
    rng = np.random.default_rng(1)
    actions = rng.normal(0, 0.3, (30, 8, 20)).astype(np.float32)
    runs = []
    for seed, threads in ((1, 1), (1, 2), (2, 1)):
        environment = lifelike.TrackingEnvironment(environments=8, seed=seed, threads=threads)
        rewards = np.array([environment.step(action)[0] for action in actions])
        runs.append((rewards, environment.observations.copy(), environment.critic_observations.copy()))
    assert data_equivalence(runs[0], runs[1], exact=True)
    assert not np.array_equal(runs[0][0], runs[2][0])


def test_clips_and_robots_can_be_given(robot, walk):
    environment = lifelike.TrackingEnvironment(environments=2, robot=robot, clips=[walk])
    assert environment.observations.shape == (2, environment.observation_size)
    with pytest.raises(lifelike.Error):
        lifelike.TrackingEnvironment(environments=2, robot="humanoid", clips=[walk])
    with pytest.raises(lifelike.Error, match=r"actions: expected shape \[2, 20\]"):
        environment.step(np.zeros((2, 19)))
    with pytest.raises(lifelike.Error, match="expected 0 to 1, got 2"):
        environment.reset([2])


def test_observations_are_views_that_a_step_overwrites():
    environment = lifelike.TrackingEnvironment(environments=4)
    view, kept = environment.observations, environment.observations.copy()
    environment.step(np.zeros((4, 20)))
    assert not np.array_equal(view, kept) and np.shares_memory(view, environment.observations)


def test_gymnasium_accepts_the_spaces_and_what_steps_return():
    envs = make()
    check_observation_space(envs.single_observation_space)
    check_action_space(envs.single_action_space)
    check_space_limit(envs.single_action_space, "action")
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    observations, info = envs.reset(seed=3)
    assert observations in envs.observation_space and info == {}
    envs.action_space.seed(3)
    for _ in range(20):
        observations, rewards, terminated, truncated, info = envs.step(envs.action_space.sample())
        assert observations in envs.observation_space
        assert rewards.shape == terminated.shape == truncated.shape == (16,)
        assert (rewards.dtype, terminated.dtype, truncated.dtype) == (np.float32, bool, bool)
        assert np.isfinite(rewards).all() and isinstance(info, dict)


def test_gymnasiums_determinism_checks_hold():
    first, second = make(), make()
    assert data_equivalence(first.reset(seed=5), second.reset(seed=5), exact=True)
    again = first.reset(seed=5)
    assert data_equivalence(again, second.reset(seed=5), exact=True)
    assert not data_equivalence(first.reset(seed=6)[0], again[0], exact=True)
    first.reset(seed=5)
    action = np.full(first.action_space.shape, 0.1, np.float32)
    for _ in range(10):
        assert data_equivalence(first.step(action), second.step(action), exact=True)
    assert not np.array_equal(first.reset()[0], again[0]), "without a seed the random numbers go on"


def test_returned_data_is_not_reused_unless_asked_for():
    for copy in (True, False):
        envs = make(copy=copy)
        first, _ = envs.reset(seed=1)
        kept = first.copy()
        second = envs.step(envs.action_space.sample())[0]
        assert np.shares_memory(first, second) is not copy
        assert np.array_equal(first, kept) is copy


def test_episodes_that_are_cut_have_their_last_observation():
    envs = make(4, **SHORT)
    envs.reset(seed=1)
    seen = 0
    for _ in range(40):
        before = envs.environment.observations.copy()
        observations, _, terminated, truncated, info = envs.step(np.zeros(envs.action_space.shape, np.float32))
        assert np.array_equal(info.get("_final_obs", np.zeros(4, bool)), truncated)
        for index in np.flatnonzero(truncated):
            final = info["final_obs"][index]
            assert final in envs.single_observation_space
            # One step leads to it, and a new episode begins elsewhere.
            assert np.linalg.norm(final - before[index]) < np.linalg.norm(observations[index] - before[index])
            seen += 1
    assert seen >= 4


def test_gymnasiums_wrappers_work():
    envs = RecordEpisodeStatistics(NormalizeReward(ClipAction(make(4, **SHORT))))
    envs.reset(seed=1)
    lengths = []
    for _ in range(40):
        info = envs.step(np.zeros(envs.action_space.shape, np.float32))[4]
        if "episode" in info:
            lengths.extend(info["episode"]["l"][info["_episode"]])
    assert lengths and max(lengths) == 10, "0.2 s at 50 Hz"


def test_rsl_rl_accepts_the_environment():
    torch = pytest.importorskip("torch", reason="NOT RUN: torch is not installed", exc_type=ImportError)
    pytest.importorskip("rsl_rl", reason="NOT RUN: rsl-rl-lib is not installed", exc_type=ImportError)
    from lifelike.rsl_rl import TrackingVecEnv

    environment = TrackingVecEnv(environments=4, **SHORT)
    observations = environment.get_observations()
    assert observations["policy"].shape == (4, environment.environment.observation_size)
    kept = observations["policy"].clone()
    outs = 0
    for _ in range(40):
        following, rewards, dones, extras = environment.step(torch.zeros(4, environment.num_actions))
        assert rewards.shape == dones.shape == extras["time_outs"].shape == (4,)
        assert not (extras["time_outs"] & ~dones).any() and (environment.episode_length_buf[dones] == 0).all()
        outs += int(extras["time_outs"].sum())
    assert outs >= 4 and torch.equal(observations["policy"], kept), "a step overwrites no observation"
