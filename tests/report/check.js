// Appended to a report by the test: exercises each plot as a hand does, and posts what it found to the page around it.
"use strict";
(() => {
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));

  // Series have hues; axes, grid and text are grey.
  const painted = (canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      const [red, green, blue, alpha] = [data[i], data[i + 1], data[i + 2], data[i + 3]];
      if (alpha > 30 && Math.max(red, green, blue) - Math.min(red, green, blue) > 50) count++;
    }
    return count;
  };

  // uPlot ignores a drag without movement.
  const mouse = (target, type, x, y) => target.dispatchEvent(
    new MouseEvent(type, { bubbles: true, clientX: x, clientY: y, button: 0, detail: 1, movementX: 9, view: window }));

  const panel = async (box) => {
    const over = box.querySelector(".u-over"), canvas = box.querySelector("canvas");
    const place = over.getBoundingClientRect();
    const at = (share) => place.left + share * place.width, middle = place.top + place.height / 2;
    const read = () => [...box.querySelectorAll(".u-legend .u-value")].map((cell) => cell.textContent);
    const before = canvas.toDataURL();
    mouse(over, "mouseenter", at(0.5), middle);
    mouse(over, "mousemove", at(0.5), middle);
    await wait(30);
    const values = read();
    mouse(over, "mousedown", at(0.3), middle);
    mouse(document, "mousemove", at(0.6), middle);
    mouse(over, "mousemove", at(0.6), middle);
    await wait(30);
    mouse(document, "mouseup", at(0.6), middle);
    await wait(30);
    const zoomed = canvas.toDataURL() !== before;
    mouse(over, "dblclick", at(0.5), middle);
    await wait(30);
    mouse(over, "mouseleave", at(0.5), middle);
    const ticks = canvas.getBoundingClientRect();
    return {
      label: box.querySelector(".label").textContent,
      painted: painted(canvas),
      width: ticks.width,
      values,
      zoomed,
      returned: canvas.toDataURL() === before,
    };
  };

  const check = async () => {
    const figures = [];
    for (const place of document.querySelectorAll("[data-figure]")) {
      const panels = [];
      for (const box of place.querySelectorAll(".panel")) panels.push(await panel(box));
      figures.push({ name: place.dataset.figure, panels });
    }
    parent.postMessage(JSON.stringify({
      width: innerWidth,
      page_width: document.documentElement.scrollWidth,
      is_dark: matchMedia("(prefers-color-scheme: dark)").matches,
      ground: getComputedStyle(document.body).backgroundColor,
      verdict: document.querySelector(".verdict").textContent,
      requests: performance.getEntriesByType("resource").map((entry) => entry.name),
      errors: window.checkErrors,
      figures,
    }), "*");
  };
  window.addEventListener("load", () => setTimeout(check, 50));
})();
