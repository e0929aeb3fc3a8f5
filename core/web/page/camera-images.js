// Yields the images of a <video> as the browser shows them.

/**
 * Calls `seen({ time, missed })` for each image: its time in seconds, and the count of images missed before it.
 * Returns a function that stops the calls.
 */
export function eachImage(video, seen) {
  return video.requestVideoFrameCallback === undefined ? byScreen(video, seen) : byVideo(video, seen);
}

function byVideo(video, seen) {
  let [handle, last] = [0, null];
  const next = (_, { mediaTime, presentedFrames }) => {
    handle = video.requestVideoFrameCallback(next);
    const missed = last === null ? 0 : Math.max(presentedFrames - last - 1, 0);
    last = presentedFrames;
    seen({ time: mediaTime, missed });
  };
  handle = video.requestVideoFrameCallback(next);
  return () => video.cancelVideoFrameCallback(handle);
}

// For browsers without requestVideoFrameCallback: checks in each animation frame whether the video's time has changed.
function byScreen(video, seen) {
  let [handle, last] = [0, -1];
  const next = () => {
    handle = requestAnimationFrame(next);
    if (video.readyState >= HTMLMediaElement.HAVE_CURRENT_DATA && video.currentTime !== last) {
      last = video.currentTime;
      seen({ time: last, missed: 0 });
    }
  };
  next();
  return () => cancelAnimationFrame(handle);
}
