"""The State Augmentation Transformer of thesis chapter 2 in PyTorch, from the equations of Lim et al. 2021: what ours is compared with.

A sequence is read once: the encoder's LSTM goes over all steps, each step's decoder is one step of another LSTM that goes on from
the encoder's state of the step before, and attention looks from each present row at the K past rows before it and at itself.
"""

import torch
from torch import nn
from torch.nn import functional as F


class GateAddNorm(nn.Module):
    def __init__(self, inputs, width):
        super().__init__()
        self.linear = nn.Linear(inputs, 2 * width)
        self.norm = nn.LayerNorm(width)

    def forward(self, x, skip):
        return self.norm(skip + F.glu(self.linear(x)))

    def named(self, name):
        yield f"{name}.weight", self.linear.weight
        yield f"{name}.bias", self.linear.bias
        yield f"{name}.norm.gain", self.norm.weight
        yield f"{name}.norm.bias", self.norm.bias


def linear(name, layer):
    yield f"{name}.weight", layer.weight
    yield f"{name}.bias", layer.bias


class GatedResidual(nn.Module):
    def __init__(self, inputs, hidden, outputs):
        super().__init__()
        self.inner = nn.Linear(inputs, hidden)
        self.outer = nn.Linear(hidden, hidden)
        self.gate = GateAddNorm(hidden, outputs)
        self.skip = nn.Linear(inputs, outputs) if inputs != outputs else None

    def forward(self, x):
        return self.gate(self.outer(F.elu(self.inner(x))), self.skip(x) if self.skip else x)

    def named(self, name):
        yield from linear(f"{name}.inner", self.inner)
        yield from linear(f"{name}.outer", self.outer)
        yield from self.gate.named(f"{name}.gate")
        if self.skip:
            yield from linear(f"{name}.skip", self.skip)


class VariableSelection(nn.Module):
    def __init__(self, variables, embedding, width):
        super().__init__()
        self.embedding = nn.ModuleList(nn.Linear(1, embedding) for _ in range(variables))
        self.all = GatedResidual(variables * embedding, width, variables)
        self.single = nn.ModuleList(GatedResidual(embedding, embedding, width) for _ in range(variables))

    def forward(self, x):
        parts = [e(x[..., v : v + 1]) for v, e in enumerate(self.embedding)]
        weights = torch.softmax(self.all(torch.cat(parts, -1)), -1)
        values = torch.stack([g(p) for g, p in zip(self.single, parts)], -1)
        return (values * weights.unsqueeze(-2)).sum(-1), weights

    def named(self, name):
        yield from self.all.named(f"{name}.all")
        for v, one in enumerate(self.single):
            yield from one.named(f"{name}.{v}")

    def stacked(self, name):
        yield f"{name}.embedding.weight", [e.weight for e in self.embedding]
        yield f"{name}.embedding.bias", [e.bias for e in self.embedding]


class HistoryAttention(nn.Module):
    """Heads with queries and keys of their own and one value; the mean of their outputs through one last map."""

    def __init__(self, width, heads, steps):
        super().__init__()
        self.heads, self.steps, d = heads, steps, width // heads
        self.query, self.key = nn.Linear(width, width), nn.Linear(width, width)
        self.value, self.output = nn.Linear(width, d), nn.Linear(d, width)

    def forward(self, past, present):
        count, sequences, width = present.shape
        d = width // self.heads
        heads = lambda x: x.reshape(count, sequences, self.heads, d)
        q, before, own = heads(self.query(present)), heads(self.key(past)), heads(self.key(present))
        scores = torch.einsum("tshd,ushd->shtu", q, before)
        t = torch.arange(count)
        band = (t[None, :] < t[:, None]) & (t[None, :] >= t[:, None] - self.steps)
        scores = scores.masked_fill(~band, -torch.inf)
        scores = torch.cat([scores, torch.einsum("tshd,tshd->sht", q, own).unsqueeze(-1)], -1) / d**0.5
        weights = torch.softmax(scores, -1).mean(1)  # over heads: [s, t, u + 1]
        mixed = torch.einsum("stu,usd->tsd", weights[..., :-1], self.value(past))
        mixed = mixed + weights[..., -1].T.unsqueeze(-1) * self.value(present)
        return self.output(mixed), weights

    def profile(self, weights):
        """The mean weight of each step before, the latest first, and of the present one, of rows with whole histories."""
        rows = [
            torch.cat([row[t - self.steps : t].flip(0), row[-1:]])
            for sequence in weights
            for t, row in enumerate(sequence)
            if t >= self.steps
        ]
        return torch.stack(rows).mean(0)

    def named(self, name):
        for part in ("query", "key", "value", "output"):
            yield from linear(f"{name}.{part}", getattr(self, part))


class Memory(nn.LSTM):
    def named(self, name):
        yield f"{name}.input", self.weight_ih_l0
        yield f"{name}.recurrent", self.weight_hh_l0

    def summed(self, name):
        yield f"{name}.bias", self.bias_ih_l0, self.bias_hh_l0


class Sat(nn.Module):
    def __init__(self, inputs, outputs, embedding, width, heads, history, backbone="lstm", attention=True):
        super().__init__()
        self.select_past = VariableSelection(inputs + outputs + 1, embedding, width)
        self.select_present = VariableSelection(inputs, embedding, width)
        self.backbone = backbone
        if backbone == "dense":
            self.dense = nn.ModuleList(nn.Linear(width, width) for _ in range(2))
        if backbone == "lstm":
            self.encoder, self.decoder = Memory(width, width), Memory(width, width)
            self.lstm_gate = GateAddNorm(width, width)
        self.attention = HistoryAttention(width, heads, history) if attention else None
        if attention:
            self.attention_gate = GateAddNorm(width, width)
            self.residual = GatedResidual(width, width, width)
            self.output_gate = GateAddNorm(width, width)
        self.output = nn.Linear(width, outputs)

    def forward(self, rows, fed_back):
        past, _ = self.select_past(torch.cat([rows, fed_back], -1))
        present, _ = self.select_present(rows)
        if self.backbone == "dense":
            layers = lambda x: F.relu(self.dense[1](F.relu(self.dense[0](x))))
            past, present = layers(past), layers(present)
        if self.backbone == "lstm":
            steps, sequences, width = past.shape
            # PyTorch's LSTM gives no cells but the last: it is asked step by step.
            zeros = torch.zeros(1, sequences, width, dtype=past.dtype)
            h, c = zeros, zeros
            hs, cs = [zeros[0]], [zeros[0]]
            for t in range(steps):
                _, (h, c) = self.encoder(past[t : t + 1], (h, c))
                hs.append(h[0])
                cs.append(c[0])
            before = torch.stack(hs[:-1]).reshape(1, -1, width), torch.stack(cs[:-1]).reshape(1, -1, width)
            shown, _ = self.decoder(present.reshape(1, -1, width), before)
            past = self.lstm_gate(torch.stack(hs[1:]), past)
            present = self.lstm_gate(shown.reshape(steps, sequences, width), present)
        # Where the error of the step before was measured, what is predicted is its change.
        known = torch.cat([torch.zeros_like(fed_back[:1]), fed_back[:-1]])
        known = known[..., :-1] * F.relu(known[..., -1:])
        if self.attention is None:
            return self.output(present) + known
        mixed, _ = self.attention(past, present)
        x = self.residual(self.attention_gate(mixed, present))
        return self.output(self.output_gate(x, present)) + known

    def parts(self):
        yield "encoder.selection", self.select_past
        yield "decoder.selection", self.select_present
        if self.backbone == "lstm":
            yield "encoder.lstm", self.encoder
            yield "decoder.lstm", self.decoder
            yield "lstm_gate", self.lstm_gate
        if self.attention:
            yield "attention", self.attention
            yield "attention_gate", self.attention_gate
            yield "residual", self.residual
            yield "output_gate", self.output_gate

    def named(self):
        """Name, weights and gradients as ours are laid out."""
        turn = lambda t: t.T if t.dim() == 2 else t
        for name, part in self.parts():
            for key, p in part.named(name):
                yield key, turn(p), turn(p.grad)
            if hasattr(part, "stacked"):
                for key, ps in part.stacked(name):
                    grads = torch.stack([p.grad.reshape(-1) for p in ps])
                    yield key, torch.stack([p.reshape(-1) for p in ps]), grads
            if hasattr(part, "summed"):
                for key, a, b in part.summed(name):
                    yield key, a + b, a.grad
        if self.backbone == "dense":
            for i, layer in enumerate(self.dense):
                for key, p in linear(f"dense.{i}", layer):
                    yield key, turn(p), turn(p.grad)
        for key, p in linear("output", self.output):
            yield key, turn(p), turn(p.grad)
