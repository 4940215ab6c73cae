// Keys: play, step, speed, points of view, switches.

export function listenToKeys(clock, panel) {
  const step = (part) => () => {
    clock.play(false);
    clock.set(clock.time + part * clock.duration);
  };
  const bindings = [
    ["Space", " ", "play or pause", () => clock.play(!clock.playing)],
    ["←", "ArrowLeft", "back by a thousandth of the span", step(-0.001)],
    ["→", "ArrowRight", "ahead by a thousandth of the span", step(0.001)],
    ["Home", "Home", "to the start", step(-1)],
    ["End", "End", "to the end", step(1)],
    ["+", "+", "faster", () => clock.change(1)],
    ["-", "-", "slower", () => clock.change(-1)],
    ["1", "1", "from inertial space", () => panel.choose("inertial")],
    ["2", "2", "from the observer", () => panel.choose("observer")],
    ["3", "3", "from the Sun", () => panel.choose("sun")],
    ["4", "4", "from the body", () => panel.choose("body")],
    ["a", "a", "body axes", () => panel.toggle("axes")],
    ["p", "p", "Poinsot's construction", () => panel.toggle("poinsot")],
    ["s", "s", "shadows", () => panel.toggle("shadows")],
  ];
  const list = document.querySelector("#help dl");
  for (const [name, , text] of bindings) {
    const term = document.createElement("dt");
    const meaning = document.createElement("dd");
    term.textContent = name;
    meaning.textContent = text;
    list.append(term, meaning);
  }
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const found = bindings.find(([, key]) => key === event.key);
    if (!found) return;
    event.preventDefault();
    found[3]();
  });
}
