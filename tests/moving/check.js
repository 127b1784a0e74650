// Put into a copy of a page by report_browser.rs: tries what a reader would, and
// writes what it found into the page.
"use strict";
(async () => {
  const failed = [];
  const expect = (good, what) => { if (!good) failed.push(what); };
  const one = (selector) => document.querySelector(selector);
  const all = (selector) => [...document.querySelectorAll(selector)];
  const press = (key, on = document.body) => {
    on.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
  };
  const data = JSON.parse(one("#frames").textContent);
  try {
    for (const [k, address] of data.pictures.entries()) {
      const picture = new Image();
      await new Promise((done) => {
        picture.onload = done;
        picture.onerror = done;
        picture.src = address;
      });
      expect(picture.naturalWidth > 0, `picture ${k} does not load`);
    }
    const stage = one(".stage");
    const name = () => one("#frame-name").textContent;
    const root = document.documentElement;
    const fits = (when) => expect(
      root.scrollWidth <= root.clientWidth,
      `wider than the window by ${root.scrollWidth - root.clientWidth} ${when}`);
    for (let setting = 0; setting < data.shown.length; setting += 1) {
      const { label, frames } = data.shown[setting];
      const visible = all("[data-shown]").filter((part) => !part.hidden);
      expect(visible.every((part) => Number(part.dataset.shown) === setting), `parts of ${label}`);
      expect(visible.length > 0, `nothing of ${label}`);
      for (const { name: frame } of frames) {
        expect(name().includes(frame), `${frame} is not shown but ${name()}`);
        for (const img of stage.querySelectorAll("img")) {
          for (let wait = 0; wait < 100 && !img.complete; wait += 1) {
            await new Promise((done) => setTimeout(done, 10));
          }
          expect(img.naturalWidth > 0 && img.alt.includes(frame), `picture of ${frame}`);
        }
        const before = name();
        press("ArrowRight");
        expect(frames.length < 2 || name() !== before, `ArrowRight does nothing at ${before}`);
      }
      press("ArrowLeft");
      expect(name().includes(frames[frames.length - 1].name), `ArrowLeft leads to ${name()}`);
      press("ArrowRight");
      for (const [k, mode] of ["slider", "side", "flicker", "difference"].entries()) {
        press(String(k + 1));
        expect(stage.classList.contains(mode), `key ${k + 1} does not show ${mode}`);
        fits(`with ${mode} of ${label}`);
        const pressed = all("button[aria-pressed=true]").map((button) => button.dataset.mode);
        expect(pressed.join() === mode, `pressed is ${pressed}`);
      }
      press("3");
      const first = stage.classList.contains("first");
      press(" ");
      expect(stage.classList.contains("first") !== first, "space does not change the picture");
      press("1");
      if (data.shown.length > 1) press("n");
    }
    if (data.shown.length > 1) {
      expect(name().includes(data.shown[0].label), `n does not come around: ${name()}`);
      press("p");
      expect(name().includes(data.shown.at(-1).label), "p does not go back");
      const row = one("tr[data-choose='0']");
      row.focus();
      expect(document.activeElement === row, "a row takes no focus");
      press("Enter", row);
      expect(name().includes(data.shown[0].label), "Enter on a row does not choose it");
      for (const which of ["#speed", "#error"]) {
        const choice = one(which);
        for (const option of choice.options) {
          choice.value = option.value;
          choice.dispatchEvent(new Event("change"));
          const curves = all("[data-curve]").filter((curve) => !curve.hidden);
          const wanted = `${one("#speed").value},${one("#error").value}`;
          expect(curves.length === 1 && curves[0].dataset.curve === wanted, `curve ${wanted}`);
        }
      }
    }
    const slider = one("input[type=range]");
    slider.value = "25";
    slider.dispatchEvent(new Event("input"));
    expect(stage.style.getPropertyValue("--at") === "25%", "the slider does nothing");
    const colour = (words) => getComputedStyle(one(words)).color;
    expect(colour("body") !== getComputedStyle(document.body).backgroundColor, "ink on ink");
  } catch (error) {
    failed.push(String(error));
  }
  const found = JSON.stringify({
    failed,
    pictures: data.pictures.length,
    settings: data.shown.length,
    width: innerWidth,
  });
  // In a frame, the page around it is the one that is printed.
  if (parent !== window) {
    parent.postMessage(found, "*");
    return;
  }
  const text = document.createElement("pre");
  text.id = "found";
  text.textContent = found;
  document.body.append(text);
})();
