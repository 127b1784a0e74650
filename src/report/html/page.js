"use strict";
(() => {
  const { pictures, shown } = JSON.parse(document.getElementById("frames").textContent);
  const every = (selector, each) => document.querySelectorAll(selector).forEach(each);

  const speed = document.getElementById("speed");
  const error = document.getElementById("error");
  if (speed && error) {
    const draw = () => every("[data-curve]", (drawing) => {
      drawing.hidden = drawing.dataset.curve !== speed.value + "," + error.value;
    });
    speed.addEventListener("change", draw);
    error.addEventListener("change", draw);
    // A browser that reloads keeps what was chosen.
    draw();
  }

  const viewer = document.getElementById("viewer");
  if (!viewer) return;
  const stage = viewer.querySelector(".stage");
  const [a, b] = stage.querySelectorAll("img");
  const slider = viewer.querySelector("input[type=range]");
  const title = document.getElementById("frame-name");
  const choice = document.getElementById("shown");
  const modes = ["slider", "side", "flicker", "difference"];
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let chosen = 0;
  let at = 0;
  let mode = "slider";
  let timer = 0;

  const around = (k, length) => ((k % length) + length) % length;

  function show(frame) {
    const { label, frames } = shown[chosen];
    stage.hidden = !frames.length;
    title.textContent = label;
    if (!frames.length) return;
    at = around(frame, frames.length);
    const { name, words } = frames[at];
    a.src = pictures[frames[at].a];
    b.src = pictures[frames[at].b];
    a.alt = "A, " + name;
    b.alt = "B, " + name;
    title.textContent = [shown.length > 1 ? label : "", name, words].filter(Boolean).join(" — ");
    every("tr[data-frame]", (row) => {
      row.setAttribute("aria-selected", String(Number(row.dataset.frame) === at));
    });
  }

  function choose(next) {
    chosen = around(next, shown.length);
    if (choice) choice.value = String(chosen);
    every("[data-shown]", (part) => {
      part.hidden = Number(part.dataset.shown) !== chosen;
    });
    every("tr[data-choose]", (row) => {
      row.setAttribute("aria-selected", String(Number(row.dataset.choose) === chosen));
    });
    show(0);
  }

  function look(next) {
    mode = next;
    stage.className = "stage " + mode;
    slider.disabled = mode !== "slider";
    every("button[data-mode]", (button) => {
      button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
    });
    clearInterval(timer);
    if (mode === "flicker" && !still) {
      timer = setInterval(() => stage.classList.toggle("first"), 500);
    }
  }

  // A row that can be chosen, with the mouse or with the keyboard.
  function choosable(row, act) {
    row.tabIndex = 0;
    row.addEventListener("click", act);
    row.addEventListener("keydown", (event) => {
      if (event.key === "Enter") act();
    });
  }

  slider.addEventListener("input", () => stage.style.setProperty("--at", slider.value + "%"));
  every("button[data-mode]", (button) => {
    button.addEventListener("click", () => look(button.dataset.mode));
  });
  every("[data-step]", (button) => {
    button.addEventListener("click", () => show(at + Number(button.dataset.step)));
  });
  every("tr[data-frame]", (row) => choosable(row, () => show(Number(row.dataset.frame))));
  every("tr[data-choose]", (row) => choosable(row, () => choose(Number(row.dataset.choose))));
  if (choice) choice.addEventListener("change", () => choose(Number(choice.value)));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // In a list the keys are the list's, on the slider the arrows are its own, and
    // what can be scrolled sideways is.
    const on = event.target;
    if (on instanceof HTMLSelectElement) return;
    const arrows = on !== slider && !(on instanceof Element && on.matches("figure, .scroll"));
    const key = event.key;
    if (arrows && key === "ArrowLeft") show(at - 1);
    else if (arrows && key === "ArrowRight") show(at + 1);
    else if (key === "p") choose(chosen - 1);
    else if (key === "n") choose(chosen + 1);
    else if (key >= "1" && key <= "4") look(modes[Number(key) - 1]);
    else if (key === " " && mode === "flicker" && on === document.body) {
      stage.classList.toggle("first");
      event.preventDefault();
    }
  });
  const wanted = new URLSearchParams(location.hash.slice(1));
  choose(Number(wanted.get("setting")) || 0);
  show(Number(wanted.get("frame")) || 0);
  look(modes.includes(wanted.get("mode")) ? wanted.get("mode") : "slider");
})();
