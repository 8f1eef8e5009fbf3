// Several runs over each other: the distances of their markers, as series of their own.

/** Adds to each later run, for each marker that the first run has too, the distance between the two. */
function addDistances(runs) {
  const [first, ...others] = runs;
  for (const run of others) {
    const shared = run.look.markers.filter((marker) => first.look.markers.some((each) => each.name === marker.name));
    if (!shared.length) continue;
    const values = shared.map((marker) => {
      const twin = first.look.markers.find((each) => each.name === marker.name);
      return Float64Array.from({ length: run.frames }, (_, row) => {
        const at = first.rowAt(run.time(row));
        return distance(markerAt(run, marker, { row, part: 0 }), markerAt(first, twin, at));
      });
    });
    const owners = shared.map((marker) => `${marker.name}, ${run.label}:`);
    run.groups.push({ name: "distance", kind: "pairs", owners, components: [""], units: owners.map(() => "m"), logarithmic: false });
    run.series.push({ rows: run.frames, at: (row, column) => values[column][row] });
  }
}
