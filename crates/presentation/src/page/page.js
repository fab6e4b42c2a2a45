"use strict";
// Heads of tables sort them, and long tables are filtered. Neither sign that XML gives a meaning is in here.
document.querySelectorAll("table.sorts").forEach(function (table) {
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  const heads = Array.from(table.tHead.rows[0].cells);
  const thousands = { k: 1e3, M: 1e6, G: 1e9 };
  function value(row, column) {
    const text = row.cells[column].textContent.trim();
    const parts = /^([-+]?[0-9.]+(?:e[-+]?[0-9]+)?)(?: ([kMG])\b)?/.exec(text);
    return parts ? parseFloat(parts[1]) * (thousands[parts[2]] || 1) : text;
  }
  // numbers before words, in both directions
  function order(a, b, turn) {
    if (typeof a !== typeof b) { return typeof a === "number" ? -1 : 1; }
    return a === b ? 0 : a > b ? turn : -turn;
  }
  heads.forEach(function (head, column) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", function () {
      const turn = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
      heads.forEach(function (other) { other.removeAttribute("aria-sort"); });
      head.setAttribute("aria-sort", turn === 1 ? "ascending" : "descending");
      rows.sort(function (a, b) { return order(value(a, column), value(b, column), turn); });
      body.append(...rows);
    });
  });
  if (rows.length > 8) {
    const label = document.createElement("label");
    const input = document.createElement("input");
    input.type = "search";
    label.className = "filter";
    label.append("A click on a head sorts. Filter rows: ", input);
    table.parentElement.before(label);
    input.addEventListener("input", function () {
      const words = input.value.toLowerCase().split(" ");
      rows.forEach(function (row) {
        const text = row.textContent.toLowerCase();
        row.hidden = !words.every(function (word) { return text.includes(word); });
      });
    });
  }
});
