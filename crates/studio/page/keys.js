// The keyboard: every action has a key; `?` shows them.

export const KEYS = [
  ["space", "play or pause", " ", "play"], ["T", "type a sentence", "t", "type"],
  ["← →", "one frame back or on", null], ["⇧ ← →", "one second back or on", null],
  ["Home, End", "to the start or end", null], ["- +", "slower or faster clock", null],
  [", .", "choose the block before or after", null], ["Esc", "choose nothing", null],
  ["; :", "move the block back or on", null], ["[ ]", "trim to the needle: start, end", null],
  ["S", "split at the needle", "s", "split"], ["M", "mirror", "m", "mirror"],
  ["L", "one more repetition", "l", "loop"], ["⇧ L", "one repetition less", "L", "unloop"],
  ["< >", "block slower or faster", null], ["Delete", "remove", null],
  ["A", "another take of a sentence", "a", "take"], ["B", "best of eight takes", "b", "best"],
  ["P", "push the trunk", "p", "push"], ["I", "slippery ground from here on", "i", "slippery"],
  ["R", "reference as a ghost", "r", "reference"], ["E", "colour by joint error", "e", "errors"],
  ["H", "handles on hands, feet, head, pelvis", "h", "handles"], ["K", "keep this take as a ghost", "k", "keep"],
  ["G", "make the block feasible", "g", "feasible"], ["V", "record a video", "v", "video"],
  ["F", "follow the robot", "f", "follow"], ["⇧ ↑ ↓", "look from higher or lower", null],
  ["W", "find clips like this moment", "w", "similar"], ["N", "light or dark", "n", "theme"], ["X", "export the page", "x", "page"],
  ["O", "run on the robot: show the command", "o", "robot"], ["C", "copy that command", "c", "copy"],
  ["Ctrl Z", "undo", null], ["Ctrl ⇧ Z", "redo", null],
];

const OTHERS = {
  ArrowLeft: "back", ArrowRight: "on", Home: "start", End: "end", "-": "slower", "+": "faster", "=": "faster",
  ",": "previous", ".": "next", Escape: "nothing", "[": "trimStart", "]": "trimEnd", Delete: "remove", Backspace: "remove",
  "?": "help", "/": "type", ";": "earlier", ":": "later",
};

export function keys(dialog, act) {
  document.addEventListener("keydown", (e) => {
    const typing = ["INPUT", "SELECT", "TEXTAREA"].includes(e.target.tagName) && e.target.type !== "range";
    if (typing) {
      if (e.key === "Escape") e.target.blur();
      return;
    }
    // Behind an open dialog nothing changes; that of the command may be copied.
    const open = document.querySelector("dialog[open]");
    if (open && !(open.dataset.is === "robot" && e.key === "c")) return;
    let name = OTHERS[e.key] ?? KEYS.find(([, , key]) => key === e.key)?.[3];
    if (e.ctrlKey || e.metaKey) name = { z: "undo", Z: "redo", y: "redo" }[e.key];
    else if (e.shiftKey) {
      name = {
        ArrowLeft: "secondBack", ArrowRight: "secondOn", ArrowUp: "higher", ArrowDown: "lower", "<": "blockSlower", ">": "blockFaster",
        ";": "earlier", ":": "later",
      }[e.key] ?? name;
    }
    if (!name) return;
    e.preventDefault();
    act(name);
  });
  const title = document.createElement("b");
  title.textContent = "Keys";
  const list = document.createElement("dl");
  for (const [key, words] of KEYS) {
    list.append(Object.assign(document.createElement("dt"), { textContent: key }), Object.assign(document.createElement("dd"), { textContent: words }));
  }
  const close = Object.assign(document.createElement("button"), { textContent: "Close" });
  close.addEventListener("click", () => dialog.close());
  dialog.append(title, list, close);
}
