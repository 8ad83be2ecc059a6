"""Time of one training step (forward + backward) of MDM's transformer encoder in PyTorch, to measure ours against:

    python peers/encoder/step.py [threads]
    cargo run --release -p lifelike-nn --example encoder

The same sizes and lengths; sequences are padded to the longest with a key padding mask, as MDM does. Needs torch.
"""

import sys
import time

import torch

torch.set_num_threads(int(sys.argv[1]) if len(sys.argv) > 1 else 2)

for b, short, long, c, n, h, ff in (
    (64, 30, 75, 128, 4, 4, 512),
    (64, 80, 220, 128, 4, 4, 512),
    (16, 80, 220, 512, 8, 4, 1024),
):
    layer = torch.nn.TransformerEncoderLayer(c, h, ff, dropout=0.0, activation="gelu", batch_first=True)
    encoder = torch.nn.TransformerEncoder(layer, n, enable_nested_tensor=False).train()
    lengths = torch.tensor([short + i * 37 % (long - short + 1) for i in range(b)])
    mask = torch.arange(int(lengths.max()))[None] >= lengths[:, None]
    x = torch.randn(b, int(lengths.max()), c)
    walls, cpus = [], []
    for _ in range(7):
        wall, cpu = time.perf_counter(), time.process_time()
        encoder.zero_grad()
        y = encoder(x, src_key_padding_mask=mask)
        (y * ~mask[..., None]).square().mean().backward()
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    name = f"encoder B {b}, T {short}..{long}, c {c}, n {n}, h {h}, ff {ff}"
    print(f"{name}: best {min(walls) * 1e3:.1f} ms, {min(cpus) * 1e3:.1f} ms of processor time", flush=True)
