// The ground that all robots stand on: each tells where it is from where it began, its origin, {x_mm, y_mm, heading_deg}.

const HOME = { x_mm: 0, y_mm: 0, heading_deg: 0 };

export function placer(origin) {
  const { x_mm, y_mm, heading_deg } = origin ?? HOME;
  const [sine, cosine] = [Math.sin((heading_deg * Math.PI) / 180), Math.cos((heading_deg * Math.PI) / 180)];
  return (x, y) => [x_mm + x * cosine + y * sine, y_mm - x * sine + y * cosine];
}

export function placedPose(origin, pose) {
  const [x, y] = placer(origin)(pose.x_mm, pose.y_mm);
  return { x, y, heading: pose.heading_deg + (origin ?? HOME).heading_deg };
}

// [x1, y1, x2, y2] or [x, y, radius]
export function placedObstacle(origin, obstacle) {
  const place = placer(origin);
  if (obstacle.length === 3) return [...place(obstacle[0], obstacle[1]), obstacle[2]];
  return [...place(obstacle[0], obstacle[1]), ...place(obstacle[2], obstacle[3])];
}
