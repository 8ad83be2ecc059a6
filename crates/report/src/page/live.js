// A page that stays up to date without a server: scripts beside it are loaded again and again, which pages of files may do.

const EVERY = 3000;

function live(showMotion) {
  const load = (file) => {
    const script = document.createElement("script");
    script.src = `${file}?${Date.now()}`;
    script.onload = script.onerror = () => script.remove();
    document.head.append(script);
  };
  let shown = 0;
  let timer = null;
  window.lifelikeState = ({ facts, curves, headlines, motion, done }) => {
    document.querySelector("[data-is=facts]").replaceChildren(...facts.map(([name, value]) => {
      const [row, term, text] = ["div", "dt", "dd"].map((tag) => document.createElement(tag));
      [term.textContent, text.textContent] = [name, value];
      row.append(term, text);
      return row;
    }));
    if (curves.length && !document.querySelector("figure svg:hover")) {
      Object.assign(data, { curves, headlines });
      document.querySelector("[data-is=curves]").closest("section").hidden = false;
      drawCurves(document.querySelector("[data-is=curves]"));
    }
    if (motion !== shown) load(data.live.motion);
    shown = motion;
    if (done) clearInterval(timer);
  };
  window.lifelikeMotion = showMotion;
  load(data.live.state);
  timer = setInterval(() => load(data.live.state), EVERY);
}
