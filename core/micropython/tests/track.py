# Follows the target of a recording with each tracker, and prints a line for each frame. Every 50 frames a new tracker
# continues with the saved target. .ci/micropython prepends COUNT, WIDTH, HEIGHT, BOX and frame(number).
import gc
import smr

NOTHING = "-"


def numbers(values):
    return " ".join(str(value) for value in values)


def line(answer):
    is_lost = answer.state == smr.LOST
    return numbers((
        answer.state,
        NOTHING if is_lost else numbers(answer.box),
        NOTHING if is_lost else numbers(answer.fine_box),
        answer.confidence,
        answer.ratio,
        NOTHING if answer.runner_up_ratio is None else answer.runner_up_ratio,
        NOTHING if answer.alpha is None else answer.alpha,
        NOTHING if answer.identity is None else answer.identity,
        answer.scale,
        int(answer.found_again),
    ))


def follow(name, make):
    tracker = make()
    print("|", name, 1, numbers(BOX), tracker.lock(frame(0), WIDTH, HEIGHT, BOX))
    for at in range(1, COUNT):
        if at % 50 == 0:
            saved = tracker.save()
            tracker = make()
            gc.collect()
            tracker.restore(saved, WIDTH, HEIGHT)
        print("|", name, at + 1, line(tracker.update(frame(at))))


follow("camera", smr.Paper)
follow("paper", lambda: smr.Paper(preset="paper", window_limit=(80, 70)))
follow("robust", smr.Robust)
follow("small", lambda: smr.Robust("small"))
