"""Time of one whole training step of a generator (drawing, noise, network forward and backward, clipping, Adam, average)
in PyTorch, to measure ours against:

    python peers/generator/step.py [threads] [0 or 1: one of the sizes only]
    cargo run --release -p lifelike-generation --example step

The same network, sizes, lengths and loss; sequences are padded to the longest of the batch with a key padding mask, as
MDM does. Needs torch.
"""

import copy
import math
import sys
import time

import torch
from torch import nn

torch.set_num_threads(int(sys.argv[1]) if len(sys.argv) > 1 else 2)
TEXT, MAX_TOKENS, STEPS, MOTIONS, PIECES, JOINTS = 10, 32, 50, 64, 1024, 20
# batch, width, layers, heads, inner, splines
SIZES = ((64, 128, 4, 4, 512, True), (16, 512, 8, 4, 1024, False))


def positions(p, width):
    angle = p[..., None] * torch.exp(torch.arange(0, width, 2) * (-math.log(10000.0) / width))
    return torch.stack([angle.sin(), angle.cos()], -1).flatten(-2)


class Denoiser(nn.Module):
    def __init__(self, c, n, h, ff, motion):
        super().__init__()
        self.c = c
        self.input, self.output = nn.Linear(motion, c), nn.Linear(c, motion)
        self.table, self.none = nn.Embedding(PIECES, c), nn.Parameter(torch.randn(c))
        self.step = nn.Sequential(nn.Linear(c, c), nn.SiLU(), nn.Linear(c, c))
        self.duration = nn.Linear(c, c)
        layer = nn.TransformerEncoderLayer(c, h, ff, dropout=0.0, activation="gelu", batch_first=True)
        self.encoder = nn.TransformerEncoder(layer, n, enable_nested_tensor=False)

    def forward(self, motion, lengths, steps, text, told):
        b, t, _ = motion.shape
        words = torch.where(told[:, None, None], self.table(text), self.none)
        step = self.step(positions(steps.float(), self.c)) + self.duration(positions(lengths.float(), self.c))
        x = torch.cat([words, step[:, None], self.input(motion)], 1)
        place = torch.cat([torch.arange(TEXT), MAX_TOKENS + torch.arange(1 + t)]).float()
        mask = torch.arange(TEXT + 1 + t)[None] >= (TEXT + 1 + lengths)[:, None]
        return self.output(self.encoder(x + positions(place, self.c), src_key_padding_mask=mask)[:, TEXT + 1 :])


for batch, c, n, h, ff, splines in SIZES if len(sys.argv) < 3 else [SIZES[int(sys.argv[2])]]:
    rows = [48 + i * 37 % 145 for i in range(MOTIONS)]
    tokens = [math.ceil((r - 1) / 20 / 0.2 - 1e-6) + 3 if splines else r for r in rows]
    width = 7 + JOINTS * (1 if splines else 2)
    data = [torch.randn(t, width) for t in tokens]
    net = Denoiser(c, n, h, ff, width)
    mean = copy.deepcopy(net)
    adam = torch.optim.Adam(net.parameters(), 5e-4)
    left = torch.cos((torch.arange(STEPS + 1) / STEPS + 0.008) / 1.008 * math.pi / 2) ** 2
    scales = torch.rand(width)

    def step():
        chosen = [data[i] for i in torch.randint(MOTIONS, (batch,))]
        lengths = torch.tensor([len(x) for x in chosen])
        clean = nn.utils.rnn.pad_sequence(chosen, batch_first=True)
        valid = (torch.arange(clean.shape[1])[None] < lengths[:, None])[..., None]
        steps = torch.randint(STEPS, (batch,))
        share = left[steps + 1][:, None, None]
        noisy = share.sqrt() * clean + (1 - share).sqrt() * torch.randn_like(clean)
        told = torch.rand(batch) >= 0.1
        adam.zero_grad()
        error = (net(noisy, lengths, steps, torch.randint(PIECES, (batch, TEXT)), told) - clean) * valid
        loss = (error.square().sum((1, 2)) / (lengths * width)).mean()
        if splines:
            rate = error.diff(dim=1) * valid[:, 1:]
            loss = loss + ((rate.square() * scales).sum((1, 2)) / (lengths * width)).mean()
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        adam.step()
        with torch.no_grad():
            for a, b in zip(mean.parameters(), net.parameters()):
                a.lerp_(b, 1e-4)

    step()
    times = []
    for _ in range(12):
        begun = time.perf_counter()
        step()
        times.append(1e3 * (time.perf_counter() - begun))
    times.sort()
    kind = "splines" if splines else "rows"
    print(f"{kind}, B {batch}, c {c}, n {n}, h {h}, ff {ff}: median {times[6]:.1f} ms, best {times[0]:.1f} ms", flush=True)
