//! Makes the table of word vectors with which sentences in free words are understood.
//!
//! ```text
//! cargo xtask fetch minilm
//! cargo run --release -p lifelike-generation --example word_vectors > WORDS.txt
//! python peers/language/embeddings.py third_party/minilm WORDS.txt EMBEDDINGS.f32
//! cargo run --release -p lifelike-generation --example word_vectors -- EMBEDDINGS.f32 OUT.safetensors
//! ```
//!
//! Each word is read alone by the frozen MiniLM. Of the words of its vocabulary, those nearest to a word of our phrases
//! stay. The vectors are centred and turned to their principal directions, and stored as bytes.

use std::collections::BTreeSet;
use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use lifelike_language::grammar::Grammar;
use lifelike_language::script::words_of_phrases;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Directions that are kept, and words beside those of the phrases.
const DIRECTIONS: usize = 128;
const WORDS: usize = 9_000;
/// Numbers of an embedding.
const WIDTH: usize = 384;

type Error = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Error> {
    let grammar = Grammar::builtin()?;
    let has_letters = |word: &String| word.bytes().any(|b| b.is_ascii_lowercase());
    let ours: Vec<String> = words_of_phrases(&grammar)?.into_iter().filter(has_letters).collect();
    let vocabulary = std::fs::read_to_string("third_party/minilm/vocab.txt")?;
    let is_word = |word: &&str| word.len() > 1 && word.bytes().all(|b| b.is_ascii_lowercase());
    let others: BTreeSet<&str> = vocabulary.lines().filter(is_word).collect();
    let others: Vec<String> = others.iter().filter(|w| !ours.iter().any(|o| o == *w)).map(|w| w.to_string()).collect();

    let mut arguments = std::env::args().skip(1);
    let (Some(embeddings), Some(out)) = (arguments.next(), arguments.next()) else {
        ours.iter().chain(&others).for_each(|word| println!("{word}"));
        return Ok(());
    };
    let mut ours_read = read(&embeddings, ours.len() + others.len())?;
    let others_read = ours_read.split_off(ours.len());
    let mut near: Vec<(f32, usize)> = others_read.iter().map(|v| closeness(v, &ours_read)).zip(0..).collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut all: Vec<(&String, &Vec<f32>)> = ours.iter().zip(&ours_read).collect();
    all.extend(near.iter().take(WORDS).map(|&(_, i)| (&others[i], &others_read[i])));
    all.sort_by_key(|(word, _)| *word);

    // Mean and directions of the phrases' words: what tells them apart is kept.
    let rows = DMatrix::from_fn(ours_read.len(), WIDTH, |i, j| f64::from(ours_read[i][j]));
    let mean = rows.row_mean();
    let centred = DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] - mean[j]);
    let eigen = SymmetricEigen::new(centred.transpose() * &centred);
    let mut order: Vec<usize> = (0..rows.ncols()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let turned: Vec<Vec<f64>> = all
        .iter()
        .map(|(_, v)| {
            let v = DVector::from_iterator(v.len(), v.iter().zip(mean.iter()).map(|(x, m)| f64::from(*x) - m));
            order[..DIRECTIONS].iter().map(|&at| eigen.eigenvectors.column(at).dot(&v)).collect()
        })
        .collect();

    let largest = |at: usize| turned.iter().map(|v| v[at].abs()).fold(1e-9, f64::max);
    let scale: Vec<f64> = (0..DIRECTIONS).map(|at| largest(at) / 127.0).collect();
    let byte = |(x, scale): (&f64, &f64)| (x / scale + 128.0).round().clamp(0.0, 255.0) as u8;
    let bytes: Vec<u8> = turned.iter().flat_map(|v| v.iter().zip(&scale).map(byte)).collect();
    let words: Vec<&str> = all.iter().map(|(word, _)| word.as_str()).collect();
    let text = words.join("\n").into_bytes();
    let mut file = Checkpoint::new();
    file.put_u8("words", &[text.len()], text)?;
    file.put_u8("vectors", &[all.len(), DIRECTIONS], bytes)?;
    file.put_f32("scale", &[DIRECTIONS], scale.iter().map(|x| *x as f32).collect())?;
    file.save(Path::new(&out))?;
    println!("{} words, {} of our phrases: {out}", all.len(), ours.len());
    Ok(())
}

fn read(path: &str, words: usize) -> Result<Vec<Vec<f32>>, Error> {
    let bytes = std::fs::read(path)?;
    let numbers: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    if numbers.len() != words * WIDTH {
        return Err(format!("{path}: expected {WIDTH} numbers for each of {words} words, got {}", numbers.len()).into());
    }
    Ok(numbers.chunks_exact(WIDTH).map(<[f32]>::to_vec).collect())
}

fn closeness(word: &[f32], ours: &[Vec<f32>]) -> f32 {
    let cosine = |other: &Vec<f32>| other.iter().zip(word).map(|(a, b)| a * b).sum::<f32>();
    ours.iter().map(cosine).fold(-1.0, f32::max)
}
