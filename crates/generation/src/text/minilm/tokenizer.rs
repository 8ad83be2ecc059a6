//! BERT's tokenizer for lower-case models: words and punctuation apart, accents dropped, then the longest pieces.

use std::collections::HashMap;
use std::path::Path;

use super::weights::read;
use crate::GenerationError;

/// Longest word that is looked up (characters); longer ones are unknown.
const MAX_WORD: usize = 100;
/// Letters with an accent, each followed by the letter without. Letters that are no composition (ø, ß, æ) stay.
const ACCENTS: &str = "àaáaâaãaäaåaāaăaąaçcćcĉcċcčcďdèeéeêeëeēeĕeėeęeěeĝgğgġgģgĥhìiíiîiïiĩiīiĭiįiĵjķkĺlļlľlñnńnņnňn\
òoóoôoõoöoōoŏoőoŕrŗrřrśsŝsşsšsţtťtùuúuûuüuũuūuŭuůuűuųuŵwýyÿyŷyźzżzžz";

/// A vocabulary of BERT's word pieces.
#[derive(Debug, Clone)]
pub struct BertTokenizer {
    ids: HashMap<String, u32>,
    begin: u32,
    end: u32,
    unknown: u32,
    accents: HashMap<char, char>,
}

impl BertTokenizer {
    /// Reads a `vocab.txt`: one piece a line, in the order of their ids.
    ///
    /// # Errors
    /// [`GenerationError::TextModel`] for a file that cannot be read or has no `[CLS]`, `[SEP]` and `[UNK]`.
    pub fn load(path: &Path) -> Result<Self, GenerationError> {
        let text = String::from_utf8(read(path)?).map_err(|e| GenerationError::text_model(path, e))?;
        let ids: HashMap<String, u32> = text.lines().map(str::to_owned).zip(0..).collect();
        let special = |name: &str| {
            let missing = || GenerationError::text_model(path, format!("expected a line {name}, got none"));
            ids.get(name).copied().ok_or_else(missing)
        };
        let (begin, end, unknown) = (special("[CLS]")?, special("[SEP]")?, special("[UNK]")?);
        let letters: Vec<char> = ACCENTS.chars().collect();
        let accents = letters.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
        Ok(Self { ids, begin, end, unknown, accents })
    }

    /// Returns the number of pieces.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Returns whether there is no piece; never so.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Returns the ids of a text between those of `[CLS]` and `[SEP]`, at most `most` in all.
    pub fn encode(&self, text: &str, most: usize) -> Vec<u32> {
        let mut ids = vec![self.begin];
        for word in self.split(text) {
            self.spell(&word, &mut ids);
        }
        ids.truncate(most.saturating_sub(1));
        ids.push(self.end);
        ids
    }

    /// Returns lower-case words without accents; every mark of punctuation and every ideograph is a word of its own.
    fn split(&self, text: &str) -> Vec<String> {
        let mut words = vec![String::new()];
        for c in text.to_lowercase().chars() {
            let c = self.accents.get(&c).copied().unwrap_or(c);
            let dropped = c.is_control() && !c.is_whitespace() || ('\u{300}'..='\u{36f}').contains(&c);
            if dropped || matches!(c, '\u{fffd}' | '\u{200b}'..='\u{200f}' | '\u{feff}') {
                continue;
            }
            if c.is_whitespace() {
                words.push(String::new());
            } else if is_punctuation(c) || is_ideograph(c) {
                words.extend([c.to_string(), String::new()]);
            } else if let Some(word) = words.last_mut() {
                word.push(c);
            }
        }
        words.retain(|word| !word.is_empty());
        words
    }

    /// Appends the longest pieces from the beginning, or the unknown piece for the whole word.
    fn spell(&self, word: &str, ids: &mut Vec<u32>) {
        let before = ids.len();
        let ends: Vec<usize> = word.char_indices().map(|(at, _)| at).skip(1).chain([word.len()]).collect();
        let mut at = 0;
        while at < word.len() && ends.len() <= MAX_WORD {
            let longest = ends.iter().rev().take_while(|end| **end > at).find_map(|end| {
                let piece = if at > 0 { format!("##{}", &word[at..*end]) } else { word[..*end].to_owned() };
                self.ids.get(&piece).map(|id| (*id, *end))
            });
            let Some((id, end)) = longest else { break };
            ids.push(id);
            at = end;
        }
        if at < word.len() {
            ids.truncate(before);
            ids.push(self.unknown);
        }
    }
}

/// ASCII's marks, and the common ones of other scripts.
fn is_punctuation(c: char) -> bool {
    c.is_ascii_punctuation()
        || matches!(c, '¡' | '§' | '«' | '¶' | '·' | '»' | '¿')
        || matches!(c, '\u{2010}'..='\u{2027}' | '\u{2030}'..='\u{205e}')
        || matches!(c, '\u{3001}'..='\u{3003}' | '\u{3008}'..='\u{3011}' | '\u{ff01}' | '\u{ff0c}' | '\u{ff1f}')
}

fn is_ideograph(c: char) -> bool {
    matches!(c, '\u{3400}'..='\u{4dbf}' | '\u{4e00}'..='\u{9fff}' | '\u{f900}'..='\u{faff}' | '\u{20000}'..='\u{2fa1f}')
}
