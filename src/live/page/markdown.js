import { minus } from "/dom.js";

// Renders the Markdown of the server's texts: headings, lists, tables, bold, italic and code.

export function markdown(where, text) {
  const blocks = [];
  let list = null;
  let paragraph = null;
  for (const line of text.split("\n")) {
    const heading = line.match(/^(#+) (.*)/);
    const item = line.match(/^[*-] (.*)/);
    if (!item) list = null;
    if (line.startsWith("|")) {
      const cells = line.split("|").slice(1, -1).map((cell) => cell.trim());
      if (cells.every((cell) => /^[-:]*$/.test(cell))) continue;
      if (blocks.at(-1)?.tagName !== "TABLE") blocks.push(document.createElement("table"));
      const row = document.createElement("tr");
      // An empty corner is no heading.
      row.append(...cells.map((cell, k) => inline(document.createElement(k || !cell ? "td" : "th"), cell)));
      blocks.at(-1).append(row);
    } else if (heading) {
      blocks.push(inline(document.createElement(heading[1].length < 3 ? "h2" : "h3"), heading[2]));
    } else if (item) {
      if (!list) blocks.push((list = document.createElement("ul")));
      list.append(inline(document.createElement("li"), item[1]));
    } else if (line.trim()) {
      // A marked part may continue on the next line.
      if (paragraph === null) blocks.push(document.createElement("p"));
      paragraph = paragraph === null ? line : `${paragraph} ${line}`;
      blocks.at(-1).replaceChildren();
      inline(blocks.at(-1), paragraph);
      continue;
    }
    paragraph = null;
  }
  where.replaceChildren(...blocks);
}

function inline(element, text) {
  for (const part of minus(text).split(/(\*\*[^*]+\*\*|\*[^*]+\*|`[^`]+`)/)) {
    const marked = (tag, cut) => {
      const inner = document.createElement(tag);
      inner.textContent = part.slice(cut, -cut);
      element.append(inner);
    };
    if (part.startsWith("**")) marked("strong", 2);
    else if (part.startsWith("*") && part.length > 2) marked("em", 1);
    else if (part.startsWith("`")) marked("code", 1);
    else element.append(part);
  }
  return element;
}
