// Draws the figures of the page: translates each panel into options of uPlot.
//
// A figure is { name, x_label, columns, panels }, a panel { y_label, x_range, y_range, logarithmic, categories, series },
// a series { name, colour, kind, x, y, low, high }. Curves are drawn by uPlot; bands, bars, dots and diamonds have a path
// of their own. Hovering shows the point of each series that is nearest in x.
"use strict";
(() => {
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const HEIGHT = 240;
  const WIDTHS = { line: 2, dashes: 2, thin: 1, wide: 3, band: 0, bars: 0, dots: 2, diamonds: 2 };
  let charts = [];

  const colours = () => {
    const style = getComputedStyle(document.documentElement);
    return (name) => style.getPropertyValue("--" + name).trim();
  };

  // A number with the digits of the step between ticks, or six digits.
  const text = (value, step) => {
    if (value == null || !isFinite(value)) return "";
    const size = Math.abs(value);
    if (value === 0 || (step && size < step / 1000)) return "0";
    const power = step ? Math.floor(Math.log10(step) + 1e-9) : Math.floor(Math.log10(size)) - 5;
    const mantissa = (step || 0) / 10 ** power;
    // A step of 2.5 has a digit more than one of 2 or 5.
    const last = power - (Math.abs(mantissa - Math.round(mantissa)) > 1e-6 ? 1 : 0);
    const rounded = Number(value.toPrecision(Math.max(1, Math.min(15, Math.floor(Math.log10(size)) - last + 1))));
    if (size >= 1e6 || Math.max(size, step || 0) < 1e-4) return rounded.toExponential();
    return step ? value.toFixed(Math.min(20, Math.max(0, -last))) : String(rounded);
  };

  // Index of the point nearest to x; the positions ascend.
  const nearest = (xs, x) => {
    let low = 0, high = xs.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] < x) low = middle; else high = middle;
    }
    return Math.abs(xs[low] - x) <= Math.abs(xs[high] - x) ? low : high;
  };

  const readOut = (series, x) => {
    const i = nearest(series.x, x);
    if (series.kind === "bars") {
      return x < series.low[i] || x > series.high[i] ? "" : text(series.y[i]);
    }
    if (series.low && series.low[i] !== series.high[i]) {
      const ends = text(series.low[i]) + " … " + text(series.high[i]);
      return series.kind === "band" ? ends : text(series.y[i]) + " (" + ends + ")";
    }
    return text(series.y[i]);
  };

  const position = (u) => {
    const px = uPlot.pxRatio;
    return {
      px,
      x: (value) => u.valToPos(value, "x", true),
      // A logarithmic scale has no place for values that are not positive.
      y: (value) => {
        const scale = u.scales.y;
        return u.valToPos(scale.distr === 3 ? Math.max(value, scale.min / 10) : value, "y", true);
      },
    };
  };

  const PATHS = {
    band: (series) => (u) => {
      const at = position(u), path = new Path2D();
      let first = 0;
      // A point without value ends a piece.
      for (let end = 0; end <= series.x.length; end++) {
        if (end < series.x.length && series.high[end] != null) continue;
        for (let i = first; i < end; i++) path.lineTo(at.x(series.x[i]), at.y(series.high[i]));
        for (let i = end - 1; i >= first; i--) path.lineTo(at.x(series.x[i]), at.y(series.low[i]));
        if (end > first) path.closePath();
        if (end + 1 < series.x.length) path.moveTo(at.x(series.x[end + 1]), at.y(series.high[end + 1]));
        first = end + 1;
      }
      return { fill: path, stroke: null };
    },
    bars: (series) => (u) => {
      const at = position(u), path = new Path2D(), zero = at.y(0);
      series.x.forEach((_, i) => {
        const left = at.x(series.low[i]), top = at.y(series.y[i]);
        path.rect(left, top, at.x(series.high[i]) - left, zero - top);
      });
      return { fill: path, stroke: null };
    },
    dots: (series) => (u) => {
      const at = position(u), dots = new Path2D(), whiskers = new Path2D(), radius = 3.5 * at.px;
      series.x.forEach((x, i) => {
        const left = at.x(x), middle = at.y(series.y[i]);
        dots.moveTo(left + radius, middle);
        dots.arc(left, middle, radius, 0, 2 * Math.PI);
        whiskers.moveTo(left, at.y(series.low[i]));
        whiskers.lineTo(left, at.y(series.high[i]));
      });
      return { fill: dots, stroke: whiskers };
    },
    diamonds: (series) => (u) => {
      const at = position(u), path = new Path2D(), reach = 6 * at.px;
      series.x.forEach((x, i) => {
        const left = at.x(x), top = at.y(series.y[i]);
        path.moveTo(left, top - reach);
        path.lineTo(left + reach, top);
        path.lineTo(left, top + reach);
        path.lineTo(left - reach, top);
        path.closePath();
      });
      return { fill: null, stroke: path };
    },
  };

  const isOutside = (u) => u.cursor.left == null || u.cursor.left < 0;

  const seriesOptions = (series, colour) => {
    const base = colour(series.colour);
    const alpha = { band: "38", bars: "90", dots: "ff" }[series.kind];
    return {
      label: series.name,
      stroke: base,
      fill: alpha && base + alpha,
      width: WIDTHS[series.kind],
      dash: series.kind === "dashes" ? [6, 5] : undefined,
      spanGaps: false,
      points: { show: series.kind in WIDTHS && !(series.kind in PATHS) && series.x.length === 1 },
      paths: series.kind in PATHS ? PATHS[series.kind](series) : undefined,
      value: (u) => (isOutside(u) ? "" : readOut(series, u.posToVal(u.cursor.left, "x"))),
    };
  };

  const step = (splits) => (splits.length > 1 ? Math.abs(splits[1] - splits[0]) : 0);

  // Powers of ten, and 2 and 5 times these where there are few; every other power where there are many.
  const logSplits = (low, high) => {
    const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high));
    const factors = last - first > 3 ? [1] : [1, 2, 5];
    const every = Math.ceil((last - first) / 8);
    const all = [];
    for (let power = first; power <= last; power += every) {
      all.push(...factors.map((factor) => Number(`${factor}e${power}`)));
    }
    return all.filter((value) => value >= low && value <= high);
  };

  const options = (figure, panel, colour, width) => {
    const axis = { stroke: colour("soft"), grid: { stroke: colour("line"), width: 1 }, ticks: { stroke: colour("line"), width: 1 } };
    const names = panel.categories;
    // Names that are longer than their place are turned.
    const room = (width - 90) / Math.max(1, names.length);
    const isTurned = names.some((name) => name.length * 7 > room);
    const longest = Math.max(0, ...names.map((name) => name.length));
    const x = names.length
      ? {
          splits: () => names.map((_, i) => i),
          values: (_, splits) => splits.map((i) => names[i] || ""),
          rotate: isTurned ? -90 : 0,
          size: isTurned ? Math.min(220, 24 + longest * 6.4) : 40,
        }
      : { values: (_, splits) => splits.map((v) => text(v, step(splits))), label: figure.x_label, labelSize: 20, size: 32 };
    const name = (u) => (isOutside(u) ? "" : names[Math.round(u.posToVal(u.cursor.left, "x"))] || "");
    return {
      width,
      height: HEIGHT + (isTurned ? x.size - 40 : 0),
      legend: {
        live: true,
        markers: { width: 2, dash: (u, i) => (u.series[i].dash ? "dashed" : "solid") },
      },
      cursor: {
        drag: { x: true, y: true, uni: 24 },
        points: { show: false },
        sync: figure.x_label === "time, s" ? { key: "time", scales: ["x", null] } : undefined,
      },
      scales: {
        x: { time: false, range: (_, low, high) => (low == null || isWhole(panel, low, high) ? panel.x_range : [low, high]) },
        y: { distr: panel.logarithmic ? 3 : 1, range: () => panel.y_range || [-1, 1] },
      },
      axes: [
        { ...axis, ...x },
        {
          ...axis,
          ...(panel.logarithmic && {
            splits: (u, _, low, high) => logSplits(low, high),
            filter: (u, splits) => splits,
          }),
          values: (_, splits) => splits.map((v) => text(v, panel.logarithmic ? 0 : step(splits))),
          size: (u, values) => {
            const letters = Math.max(0, ...(values || []).map((v) => v.length));
            return 18 + 7 * letters;
          },
        },
      ],
      series: [{ label: figure.x_label || "at", value: names.length ? name : (_, v) => text(v) },
        ...panel.series.map((s) => seriesOptions(s, colour))],
    };
  };

  // The range of all points is widened to that of the panel.
  const isWhole = (panel, low, high) => {
    const [first, last] = extent(panel);
    return low <= first && high >= last;
  };
  const extent = (panel) => {
    if (!panel.extent) {
      const all = panel.series.flatMap((s) => [s.x[0], s.x[s.x.length - 1]]);
      panel.extent = [Math.min(...all), Math.max(...all)];
    }
    return panel.extent;
  };

  // Two fingers zoom and move the horizontal axis.
  const touch = (u, panel) => {
    let begin = null;
    const places = (event) => [...event.touches].map((t) => t.clientX - u.over.getBoundingClientRect().left);
    u.over.addEventListener("touchstart", (event) => {
      if (event.touches.length !== 2) return;
      event.preventDefault();
      begin = places(event).map((left) => u.posToVal(left, "x"));
    }, { passive: false });
    u.over.addEventListener("touchmove", (event) => {
      if (!begin || event.touches.length !== 2) return;
      event.preventDefault();
      const [a, b] = places(event), width = u.over.clientWidth;
      if (Math.abs(b - a) < 10) return;
      const scale = (begin[1] - begin[0]) / (b - a), low = begin[0] - a * scale;
      const [first, last] = panel.x_range;
      u.setScale("x", { min: Math.max(first, low), max: Math.min(last, low + width * scale) });
    }, { passive: false });
    u.over.addEventListener("touchend", () => { begin = null; });
  };

  const draw = () => {
    charts.forEach(({ chart }) => chart.destroy());
    charts = [];
    const colour = colours();
    for (const figure of figures) {
      const place = document.querySelector(`[data-figure="${figure.name}"]`);
      if (!place) continue;
      place.textContent = "";
      place.className = "panels columns-" + figure.columns;
      for (const panel of figure.panels) {
        if (!panel.series.length) continue;
        const box = document.createElement("div");
        box.className = "panel";
        const label = document.createElement("div");
        label.className = "label";
        label.textContent = panel.y_label;
        box.append(label);
        place.append(box);
        // Null interrupts a line; positions of other series do not.
        const data = uPlot.join(panel.series.map((s) => [s.x, s.y]));
        const chart = new uPlot(options(figure, panel, colour, widthOf(box, panel)), data, box);
        touch(chart, panel);
        charts.push({ chart, box, panel });
      }
    }
  };

  // Names side by side need room: the panel scrolls where the page is narrower.
  const widthOf = (box, panel) => Math.max(200, box.clientWidth - 8, 60 + 14 * panel.categories.length);

  const fit = () => charts.forEach(({ chart, box, panel }) => {
    const width = widthOf(box, panel);
    if (width !== chart.width) chart.setSize({ width, height: chart.height });
  });

  draw();
  window.addEventListener("resize", fit);
  // The labels of the axes are measured with the width of the window: a change of the scheme draws all anew.
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
})();
