"use strict";
// What the scripts of all pages share.
const page = (() => {
  const byId = (id) => document.getElementById(id);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");

  // 65,535 parts of the range, the last of which stands for no number; or numbers of 32 bits
  const numbers = ([least, part, text]) => {
    const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
    const read = new DataView(bytes.buffer);
    const size = least === null ? 4 : 2;
    const found = new Float64Array(bytes.length / size);
    for (let k = 0; k < found.length; k += 1) {
      if (size === 4) {
        found[k] = read.getFloat32(4 * k, true);
      } else {
        const count = read.getUint16(2 * k, true);
        found[k] = count === 65535 ? NaN : least + count * part;
      }
    }
    return found;
  };
  const heading = (each) => (each.unit ? `${each.name} [${each.unit}]` : each.name);
  // Bokeh would take these for the marks of mathematics, and ask for a script that draws it
  const unmarked = (text) => text.replace(/\$\$/g, "$\u200b$").replace(/\\([[(])/g, "\\\u200b$1");
  const short = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(6))) : "-");

  const row = (head, cells) => {
    const made = document.createElement("tr");
    const first = document.createElement("th");
    first.scope = "row";
    first.textContent = head;
    made.append(first);
    for (const text of cells) {
      const cell = document.createElement("td");
      cell.className = "number";
      cell.textContent = text;
      made.append(cell);
    }
    return made;
  };
  const options = (texts) => texts.map((text, k) => {
    const option = document.createElement("option");
    option.value = k;
    option.textContent = text;
    return option;
  });

  // each root of the document goes into the element whose id is its name
  const embed = async (content) => {
    const roots = {};
    for (const root of content.roots) {
      roots[root.id] = root.attributes.name;
      byId(root.attributes.name).dataset.rootId = root.id;
    }
    await Bokeh.embed.embed_items({ report: content }, [{ docid: "report", roots, root_ids: Object.keys(roots) }]);
    return (name) => Bokeh.documents[0].get_model_by_name(name);
  };

  const ink = (darkly) => (darkly ? "#e6eaee" : "#1a1f26");
  const paintAxes = (figure, darkly) => {
    for (const axis of [...figure.below, ...figure.left]) {
      axis.setv({
        axis_label_text_color: ink(darkly), major_label_text_color: ink(darkly), axis_line_color: ink(darkly),
        major_tick_line_color: ink(darkly), minor_tick_line_color: ink(darkly), axis_label_text_font_style: "normal",
      });
    }
    for (const each of figure.center) {
      if (each.type === "Grid") each.setv({ grid_line_color: darkly ? "#3b4550" : "#d5dbe1" });
    }
  };
  // as the screen is; on paper in light
  const painted = (paint) => {
    paint(dark.matches);
    dark.addEventListener("change", () => paint(dark.matches));
    window.addEventListener("beforeprint", () => paint(false));
    window.addEventListener("afterprint", () => paint(dark.matches));
  };
  const ready = () => { document.documentElement.dataset.ready = "yes"; };
  return { byId, numbers, heading, unmarked, short, row, options, embed, ink, paintAxes, painted, ready };
})();
