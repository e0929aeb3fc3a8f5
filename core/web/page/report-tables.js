// Tables that are sorted by a click on the header of a column.

import { htmlNode } from "./dom.js";

/** Each header gets a button, so that it works by keyboard, too. */
export function makeSortable(table) {
  const headers = [...table.tHead.rows[0].cells];
  headers.forEach((header, column) => {
    const button = htmlNode("button", { type: "button", class: "sort" }, header.textContent);
    header.replaceChildren(button);
    button.addEventListener("click", () => {
      // Names from a to z first, figures from the largest.
      const first = column === 0 ? "ascending" : "descending";
      const other = column === 0 ? "descending" : "ascending";
      const order = header.getAttribute("aria-sort") === first ? other : first;
      for (const each of headers) each.removeAttribute("aria-sort");
      header.setAttribute("aria-sort", order);
      sortRows(table.tBodies[0], column, order === "ascending" ? 1 : -1);
    });
  });
}

/** Rows without a figure come last, whatever the order. */
function sortRows(body, column, sign) {
  const text = (row) => row.cells[column].textContent.trim();
  const figure = (row) => Number(text(row));
  const compare = (a, b) => {
    if (column === 0) return sign * text(a).localeCompare(text(b));
    const [one, other] = [figure(a), figure(b)];
    if (Number.isNaN(one) || Number.isNaN(other)) return Number.isNaN(one) - Number.isNaN(other);
    return sign * (one - other);
  };
  body.append(...[...body.rows].sort(compare));
}
