#!/usr/bin/env bash
# The Python package: wheel, tests, notebooks, and other stacks' readers of our files.
. "$(dirname "$0")/../common.sh"
step "the Python package: wheel, tests, notebooks"
python="$target/python"
python3 -m venv --clear "$python" || { debian python3-venv && python3 -m venv --clear "$python"; }
"$python/bin/pip" install -q 'maturin>=1.9,<2'
# The build has the features of the tests, whose compiled crates it takes.
(cd crates/python && "$python/bin/maturin" build --release --locked -o "$python/wheels")
wheel="$(realpath "$python"/wheels/lifelike-*.whl)"
"$python/bin/pip" install -q "$wheel[test]" onnx onnxruntime mcap-ros2-support
# Another stack's reader and its released policies; its tests are skipped where it does not install.
"$python/bin/pip" install -q holosoma-inference pin || not_run "holosoma's reader does not install here"
"$python/bin/pytest" -rs crates/python
