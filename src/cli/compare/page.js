"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { width, height, factor, origin, decades, errors, full } = data;
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

  // Half floats: sign, five bits of exponent, ten of mantissa.
  const half = (h) => {
    const sign = h & 0x8000 ? -1 : 1, exponent = (h >> 10) & 31, mantissa = h & 1023;
    return sign * (exponent ? (1024 + mantissa) * 2 ** (exponent - 25) : mantissa * 2 ** -24);
  };
  const floats = (text) => {
    const raw = bytes(text), values = new Float32Array(raw.length / 2);
    for (let i = 0; i < values.length; i++) values[i] = half(raw[2 * i] | (raw[2 * i + 1] << 8));
    return values;
  };
  const a = floats(data.a), b = floats(data.b), p = bytes(data.p), flip = data.flip && bytes(data.flip);
  const blocks = new Map(data.t.map(({ side, values }) =>
    [`t${side}`, { side, across: Math.ceil(full[0] / side), values: bytes(values) }]));
  // The byte of the block that a pixel of the page lies in; 127.5 is no difference.
  const blockOf = ({ side, across, values }, x, y) =>
    values[Math.floor((factor * y) / side) * across + Math.floor((factor * x) / side)];

  // Linear light to the bytes of a screen, by table: 4096 steps of the square root, where the eye is.
  const srgb = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
  const curve = new Uint8Array(4097);
  for (let i = 0; i <= 4096; i++) curve[i] = Math.round(255 * srgb((i / 4096) ** 2));
  const shown = (v) => curve[v <= 0 ? 0 : v >= 1 ? 4096 : Math.round(4096 * Math.sqrt(v))];

  // Colours along a scale, between a few that are given.
  const ramp = (stops) => (t) => {
    const at = Math.min(Math.max(t, 0), 1) * (stops.length - 1), i = Math.min(Math.floor(at), stops.length - 2);
    return stops[i].map((c, k) => c + (at - i) * (stops[i + 1][k] - c));
  };
  const heat = ramp([[8, 8, 16], [70, 20, 110], [170, 45, 110], [240, 110, 60], [255, 200, 90], [255, 255, 220]]);
  const signed = ramp([[120, 220, 255], [30, 110, 220], [10, 30, 80], [12, 12, 12], [90, 20, 10], [225, 70, 30], [255, 215, 120]]);
  const table = (colour) => {
    const lut = new Uint8Array(3 * 256);
    for (let i = 0; i < 256; i++) lut.set(colour(i / 255).map(Math.round), 3 * i);
    return lut;
  };
  const heatTable = table(heat), signedTable = table(signed);

  const $ = (id) => document.getElementById(id);
  const canvas = $("canvas"), context = canvas.getContext("2d"), legend = $("legend").getContext("2d");
  canvas.width = width;
  canvas.height = height;
  const image = context.createImageData(width, height), out = image.data;
  for (let i = 3; i < out.length; i += 4) out[i] = 255;

  const view = () => document.querySelector("input[name=view]:checked").value;
  const number = (id) => Number($(id).value);
  const luminance = (v, i) => 0.2126 * v[3 * i] + 0.7152 * v[3 * i + 1] + 0.0722 * v[3 * i + 2];

  const photograph = (picture, from, to) => {
    const gain = 2 ** number("exposure");
    for (let y = 0; y < height; y++)
      for (let i = y * width + from; i < y * width + to; i++)
        for (let c = 0; c < 3; c++) out[4 * i + c] = shown(gain * picture[3 * i + c]);
  };
  const map = (lut, value) => {
    for (let i = 0; i < width * height; i++) {
      const at = 3 * value(i);
      out[4 * i] = lut[at];
      out[4 * i + 1] = lut[at + 1];
      out[4 * i + 2] = lut[at + 2];
    }
  };
  const scale = (texts, lut) => {
    $("scale").replaceChildren(...texts.map((text) => Object.assign(document.createElement("span"), { textContent: text })));
    $("legend").hidden = !lut;
    if (!lut) return;
    for (let i = 0; i < 512; i++) {
      legend.fillStyle = `rgb(${lut.subarray(3 * (i >> 1), 3 * (i >> 1) + 3).join()})`;
      legend.fillRect(i, 0, 1, 12);
    }
  };

  let drawn = false;
  const draw = () => {
    drawn = false;
    const which = view(), range = 10 ** number("range");
    const cut = Math.round(number("divide") * width);
    if (which === "wipe") {
      photograph(a, 0, cut);
      photograph(b, cut, width);
      scale(["A to the left of the line", "B to the right"]);
    } else if (which === "a" || which === "b") {
      photograph(which === "a" ? a : b, 0, width);
      scale([]);
    } else if (which === "difference") {
      map(signedTable, (i) => {
        const t = (luminance(a, i) - luminance(b, i)) / range;
        return Math.round(127.5 + 127.5 * Math.min(Math.max(t, -1), 1));
      });
      scale([`−${range.toPrecision(2)}: A is darker`, "0", `A is brighter: +${range.toPrecision(2)}`], signedTable);
    } else if (blocks.has(which)) {
      const block = blocks.get(which);
      map(signedTable, (i) => blockOf(block, i % width, Math.floor(i / width)));
      scale([`−${errors} standard errors: A is darker`, "0", `A is brighter: +${errors}`], signedTable);
    } else if (which === "p") {
      map(heatTable, (i) => p[i]);
      scale(["p = 1", `p = 1e−${decades / 2}`, `p = 1e−${decades} or less: certainly different`], heatTable);
    } else {
      map(heatTable, (i) => flip[i]);
      scale(["0: looks the same", "FLIP", "1: as different as can be"], heatTable);
    }
    context.putImageData(image, 0, 0);
    canvas.style.cursor = which === "wipe" ? "ew-resize" : number("zoom") === 0 ? "zoom-in" : "zoom-out";
    $("line").hidden = which !== "wipe";
    $("line").style.left = `${(100 * cut) / width}%`;
    for (const [id, views] of [["exposure", "wipe a b"], ["divide", "wipe"], ["range", "difference"]])
      $(id).parentElement.hidden = !views.split(" ").includes(which);
    $("exposure").nextElementSibling.value = `${number("exposure") >= 0 ? "+" : ""}${number("exposure")} stops`;
    $("divide").nextElementSibling.value = `${Math.round(100 * number("divide"))} %`;
    $("range").nextElementSibling.value = `± ${range.toPrecision(2)}`;
    // Zoom 0 fits the page; pictures smaller than a thumb are enlarged by whole numbers.
    const zoom = number("zoom"), room = $("stage").clientWidth || width;
    const fit = width > room ? room / width : Math.max(1, Math.floor(Math.min(room, 640) / width));
    const size = zoom === 0 ? fit : 2 ** (zoom - 1);
    canvas.style.width = `${width * size}px`;
    canvas.style.height = `${height * size}px`;
    $("zoom").nextElementSibling.value = zoom === 0 ? "fitted" : `${size}×`;
  };
  const redraw = () => {
    if (!drawn) requestAnimationFrame(draw);
    drawn = true;
  };

  const cursor = { x: width >> 1, y: height >> 1 };
  const read = () => {
    const { x, y } = cursor, i = y * width + x;
    const values = (v) => [0, 1, 2].map((c) => v[3 * i + c].toPrecision(4)).join(" ");
    const chance = p[i] === 255 ? `below 1e−${decades}` : (10 ** ((-p[i] / 255) * decades)).toPrecision(2);
    $("readout").textContent =
      `pixel ${origin[0] + factor * x}, ${origin[1] + factor * y} — A: ${values(a)} — B: ${values(b)} — p ${chance}` +
      [...blocks.values()].map((block) => {
        const t = (blockOf(block, x, y) / 127.5 - 1) * errors;
        return ` — t of ${block.side} × ${block.side}: ${Math.abs(t) >= errors ? (t > 0 ? "≥ " : "≤ ") : ""}${t.toFixed(1)}`;
      }).join("") +
      (flip ? ` — FLIP ${(flip[i] / 255).toFixed(3)}` : "");
  };
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    cursor.x = Math.min(Math.max(Math.floor(((event.clientX - box.left) / box.width) * width), 0), width - 1);
    cursor.y = Math.min(Math.max(Math.floor(((event.clientY - box.top) / box.height) * height), 0), height - 1);
    read();
    if (event.buttons & 1 && view() === "wipe") {
      $("divide").value = (cursor.x + 0.5) / width;
      redraw();
    }
  };
  // As large as the slider goes, with the pixel in the middle; or all of it again.
  const enlarge = () => {
    $("zoom").value = number("zoom") === 0 ? $("zoom").max : 0;
    draw();
    const stage = $("stage"), size = canvas.clientWidth / width;
    stage.scrollLeft = (cursor.x + 0.5) * size - stage.clientWidth / 2;
    stage.scrollTop = (cursor.y + 0.5) * size - stage.clientHeight / 2;
  };
  canvas.addEventListener("pointermove", place);
  canvas.addEventListener("pointerdown", place);
  canvas.addEventListener("click", () => {
    if (view() !== "wipe") enlarge();
  });
  canvas.addEventListener("keydown", (event) => {
    if (event.key === "Enter") {
      event.preventDefault();
      enlarge();
      return;
    }
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const by = event.shiftKey ? 10 : 1;
    cursor.x = Math.min(Math.max(cursor.x + by * step[0], 0), width - 1);
    cursor.y = Math.min(Math.max(cursor.y + by * step[1], 0), height - 1);
    read();
  });
  document.addEventListener("input", redraw);
  window.addEventListener("resize", redraw);

  // The difference's scale starts where 99 of 100 pixels lie within it.
  const sizes = Float32Array.from({ length: width * height }, (_, i) => Math.abs(luminance(a, i) - luminance(b, i))).sort();
  const typical = sizes[Math.floor(0.99 * (sizes.length - 1))] || sizes[sizes.length - 1] || 0.1;
  $("range").value = Math.log10(typical).toFixed(1);
  draw();
})();
