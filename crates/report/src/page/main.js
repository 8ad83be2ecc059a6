// The page: theme, tables that sort, and what there is to show.

const data = JSON.parse(document.getElementById("data").textContent);
const query = new URLSearchParams(location.search);
const themeChanged = [];

function theme() {
  const root = document.documentElement;
  if (query.has("theme")) root.dataset.theme = query.get("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const announce = () => themeChanged.forEach((f) => f());
  system.addEventListener("change", announce);
  document.querySelector("[data-is=theme]").addEventListener("click", () => {
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : system.matches;
    root.dataset.theme = dark ? "light" : "dark";
    announce();
  });
}

function sortable(table) {
  const body = table.tBodies[0];
  [...table.tHead.rows[0].cells].forEach((cell, column) => {
    cell.addEventListener("click", () => {
      const down = cell.getAttribute("aria-sort") === "ascending";
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      cell.setAttribute("aria-sort", down ? "descending" : "ascending");
      const key = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
      const order = (a, b) => {
        const [x, y] = [Number(key(a)), Number(key(b))];
        return Number.isNaN(x) || Number.isNaN(y) ? key(a).localeCompare(key(b)) : x - y;
      };
      body.append(...[...body.rows].sort((a, b) => (down ? -1 : 1) * order(a, b)));
    });
  });
}

theme();
if (query.has("strip") && data.playbacks.length) {
  strip();
} else if (query.has("film")) {
  film();
} else {
  document.querySelectorAll("table").forEach(sortable);
  const root = document.querySelector("#playback");
  let viewer = data.playbacks.length ? new Viewer(root) : null;
  if (data.look) new RobotLook(document.querySelector("#robot"));
  if (data.curves.length) drawCurves(document.querySelector("[data-is=curves]"));
  if (data.live) {
    live((motion) => {
      Object.assign(data, motion);
      root.hidden = false;
      if (viewer) viewer.replace();
      else viewer = new Viewer(root);
    });
  }
}
document.documentElement.dataset.ready = "1";
