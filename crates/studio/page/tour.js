// A tour of the page on the first start. A cookie remembers it, which is the same for every port.

const STEPS = [
  ["Type, and it does it", "Write a sentence and press Enter. The motion appears on the timeline, and physics plays it at once.", "[data-is=sentence]", "above"],
  ["Touch it", "Drag the robot to pull it; the force is shown in newtons. Drag the ground to look around.", "[data-is=canvas]", "middle"],
  ["Cut it", "Drag blocks to reorder them and their ends to trim them. S splits, M mirrors, Ctrl Z takes anything back.", "[data-is=timeline]", "above"],
  ["See why", "Below the timeline: joint error, torque, feet on the ground. Falls are red, with their cause in the panel.", "[data-is=strips]", "above"],
  ["Keep it", "The scene is a text file, saved after every change. Export a page in one file, or a clip. Press ? for all keys.", "[data-is=export]", "below"],
];
const DONE = "lifelike-tour=done";

export function tour(root, force = false) {
  if (!force && document.cookie.split("; ").includes(DONE)) return;
  let step = 0;
  const end = () => {
    root.hidden = true;
    document.cookie = `${DONE}; max-age=31536000; path=/; SameSite=Strict`;
  };
  const show = () => {
    const [title, text, target, place] = STEPS[step];
    const box = document.querySelector(target).getBoundingClientRect();
    const row = document.createElement("div");
    const count = document.createElement("span");
    count.textContent = `${step + 1} of ${STEPS.length}`;
    const button = (words, act) => {
      const made = document.createElement("button");
      made.textContent = words;
      made.addEventListener("click", act);
      return made;
    };
    row.append(button("Skip", end), count, button(step + 1 < STEPS.length ? "Next" : "Begin", () => {
      step++;
      if (step < STEPS.length) show();
      else end();
    }));
    const heading = document.createElement("b");
    heading.textContent = title;
    root.replaceChildren(heading, document.createTextNode(text), row);
    root.hidden = false;
    const left = Math.min(Math.max(box.left + 40, 12), innerWidth - 316);
    const top = { above: box.top - root.offsetHeight - 12, below: box.bottom + 12, middle: box.top + box.height * 0.35 }[place];
    root.style.left = `${place === "middle" ? Math.max(innerWidth / 2 - 380, 12) : left}px`;
    root.style.top = `${Math.max(top, 12)}px`;
  };
  show();
}
