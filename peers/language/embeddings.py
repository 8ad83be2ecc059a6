"""Sentence embeddings of single words by the frozen all-MiniLM-L6-v2, for the table of word vectors.

    lifelike fetch minilm
    python peers/language/embeddings.py third_party/minilm WORDS.txt EMBEDDINGS.f32      # pip install numpy

WORDS.txt has a word a line; EMBEDDINGS.f32 gets 384 little-endian numbers of 32 bits a word, of unit norm. The network is
BERT's encoder (Devlin et al. 2019), one sentence at a time, in double precision.
"""

import json
import math
import re
import sys
from pathlib import Path

import numpy as np


def arrays(path):
    """The arrays of a safetensors file, by name, in double precision."""
    data = path.read_bytes()
    length = int.from_bytes(data[:8], "little")
    header = json.loads(data[8 : 8 + length])
    found = {}
    for name, entry in header.items():
        if name != "__metadata__" and entry["dtype"] == "F32":
            begin, end = (8 + length + offset for offset in entry["data_offsets"])
            found[name] = np.frombuffer(data[begin:end], "<f4").reshape(entry["shape"]).astype(float)
    return found


def pieces(word, ids):
    """Ids of the longest pieces from the beginning, or the unknown piece for the whole of a part."""
    out = []
    for part in re.findall(r"[^\W_]+|[^\w\s]|_", word.lower()):
        at, own = 0, []
        while at < len(part):
            ends = range(len(part), at, -1)
            end = next((end for end in ends if ("##" if at else "") + part[at:end] in ids), None)
            if end is None:
                own = [ids["[UNK]"]]
                break
            own.append(ids[("##" if at else "") + part[at:end]])
            at = end
        out += own
    return [ids["[CLS]"], *out, ids["[SEP]"]]


def normalised(rows, weights, name, epsilon):
    centred = rows - rows.mean(axis=-1, keepdims=True)
    scaled = centred / np.sqrt((centred**2).mean(axis=-1, keepdims=True) + epsilon)
    return scaled * weights[f"{name}.LayerNorm.weight"] + weights[f"{name}.LayerNorm.bias"]


def linear(rows, weights, name):
    return rows @ weights[f"{name}.weight"].T + weights[f"{name}.bias"]


def embedding(ids, weights, config):
    """Mean of the last hidden states, at unit norm."""
    heads, epsilon = config["num_attention_heads"], config["layer_norm_eps"]
    rows = weights["embeddings.word_embeddings.weight"][ids]
    rows = rows + weights["embeddings.position_embeddings.weight"][: len(ids)]
    rows = normalised(rows + weights["embeddings.token_type_embeddings.weight"][0], weights, "embeddings", epsilon)
    for layer in range(config["num_hidden_layers"]):
        at = f"encoder.layer.{layer}"
        q, k, v = (
            linear(rows, weights, f"{at}.attention.self.{part}").reshape(len(ids), heads, -1).swapaxes(0, 1)
            for part in ("query", "key", "value")
        )
        scores = np.exp(q @ k.swapaxes(1, 2) / math.sqrt(q.shape[-1]))
        mixed = (scores / scores.sum(axis=-1, keepdims=True) @ v).swapaxes(0, 1).reshape(len(ids), -1)
        rows = normalised(rows + linear(mixed, weights, f"{at}.attention.output.dense"), weights, f"{at}.attention.output", epsilon)
        wide = linear(rows, weights, f"{at}.intermediate.dense")
        wide = wide * 0.5 * (1.0 + np.vectorize(math.erf)(wide / math.sqrt(2.0)))
        rows = normalised(rows + linear(wide, weights, f"{at}.output.dense"), weights, f"{at}.output", epsilon)
    mean = rows.mean(axis=0)
    return mean / np.linalg.norm(mean)


def main():
    folder, words, out = map(Path, sys.argv[1:4])
    config = json.loads((folder / "config.json").read_text())
    ids = {piece: i for i, piece in enumerate((folder / "vocab.txt").read_text().splitlines())}
    weights = arrays(folder / "model.safetensors")
    rows = [embedding(pieces(word, ids), weights, config) for word in words.read_text().splitlines()]
    out.write_bytes(np.array(rows, "<f4").tobytes())


main()
