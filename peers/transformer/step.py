"""Time of one training step (forward + backward) of the Spline-based Transformer in PyTorch, to measure ours against:

    python peers/transformer/step.py [threads]
    cargo run --release -p lifelike-nn --example transformer

The same networks, batches and loss as in that example; attention is PyTorch's fused one with an additive bias. Prints wall
and processor time, the best of several steps, and the most memory that was ever used. Needs torch.
"""

import resource
import sys
import time

import torch
import torch.nn.functional as F
from torch.nn import GELU, Linear, Module, ModuleList, Parameter, RMSNorm, Sequential

torch.set_num_threads(int(sys.argv[1]) if len(sys.argv) > 1 else 2)


def alibi(heads, tokens):
    slopes = torch.tensor([2 ** (-8 * (i + 1) / heads) for i in range(heads)])
    p = torch.arange(tokens).float()
    return -slopes.reshape(-1, 1, 1) * (p[None] - p[:, None]).abs()


class Block(Module):
    def __init__(self, c, heads):
        super().__init__()
        self.heads = heads
        self.norm_1, self.norm_2 = RMSNorm(c), RMSNorm(c)
        self.projection, self.output = Linear(c, 3 * c, bias=False), Linear(c, c, bias=False)
        self.inner, self.outer = Linear(c, c, bias=False), Linear(c, c, bias=False)

    def forward(self, x, bias):
        b, t, c = x.shape
        parts = self.projection(self.norm_1(x)).split(c, 2)
        q, k, v = (y.reshape(b, t, self.heads, c // self.heads).transpose(1, 2) for y in parts)
        y = F.scaled_dot_product_attention(q, k, v, attn_mask=bias)
        x = x + self.output(y.transpose(1, 2).reshape(b, t, c))
        return x + self.outer(F.gelu(self.inner(self.norm_2(x))))


class Autoencoder(Module):
    def __init__(self, inputs, d, n, heads, c):
        super().__init__()
        self.heads = heads
        self.input = Sequential(Linear(inputs, c), GELU(), Linear(c, c))
        self.control = Parameter(torch.randn(4, c))
        self.encoder = ModuleList(Block(c, heads) for _ in range(n))
        self.decoder = ModuleList(Block(c, heads) for _ in range(n))
        self.encoder_norm, self.decoder_norm = RMSNorm(c), RMSNorm(c)
        self.to_latent, self.from_latent, self.output = Linear(c, d), Linear(d, c), Linear(c, inputs)

    def forward(self, x):
        b, t, _ = x.shape
        y, bias = torch.cat([self.control.expand(b, -1, -1), self.input(x)], 1), alibi(self.heads, t + 4)
        for block in self.encoder:
            y = block(y, bias)
        points = self.to_latent(self.encoder_norm(y)[:, :4])
        u = torch.linspace(0, 1, t)
        weights = torch.stack([(1 - u) ** 3, 3 * (1 - u) ** 2 * u, 3 * (1 - u) * u**2, u**3], 1)
        y, bias = self.from_latent(weights @ points), alibi(self.heads, t)
        for block in self.decoder:
            y = block(y, bias)
        return self.output(self.decoder_norm(y))


for b, t, inputs, d, n, heads, c in ((64, 256, 2, 3, 4, 4, 64), (64, 64, 66, 64, 4, 8, 128)):
    x, network = torch.randn(b, t, inputs), Autoencoder(inputs, d, n, heads, c)
    walls, cpus = [], []
    for _ in range(8):
        wall, cpu = time.perf_counter(), time.process_time()
        network.zero_grad()
        network(x).square().mean().backward()
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    name = f"autoencoder B {b}, T {t}, D {inputs}, d {d}, n {n}, h {heads}, c {c}"
    print(f"{name}: best {min(walls) * 1e3:.2f} ms, {min(cpus) * 1e3:.2f} ms of processor time", flush=True)
print(f"most memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")
