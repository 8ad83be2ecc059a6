"""Time of one training step of the State Augmentation Transformer in PyTorch (sat.py): forward, L1 loss, backward, Adam; 16 stretches
of 256 steps. `cargo run --release -p lifelike-augmentation --example sat_step` is ours.

    python peers/augmentation/step.py [threads]
"""

import sys
import time

import torch

from sat import Sat

torch.set_num_threads(int(sys.argv[1]) if len(sys.argv) > 1 else 2)
torch.manual_seed(0)
INPUTS, OUTPUTS, STEPS, SEQUENCES = 9, 2, 256, 16
net = Sat(INPUTS, OUTPUTS, 8, 32, 4, 128)
adam = torch.optim.AdamW(net.parameters(), lr=1e-3)
rows, error = torch.randn(STEPS, SEQUENCES, INPUTS), torch.randn(STEPS, SEQUENCES, OUTPUTS)
fed = torch.zeros(STEPS, SEQUENCES, OUTPUTS + 1)
best = float("inf")
for _ in range(7):
    began = time.perf_counter()
    adam.zero_grad()
    (net(rows, fed) - error).abs().mean().backward()
    adam.step()
    best = min(best, time.perf_counter() - began)
print(f"{sum(p.numel() for p in net.parameters())} parameters, best of 7: {1e3 * best:.1f} ms")
