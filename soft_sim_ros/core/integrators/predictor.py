"""The first guess of the accelerations of a step, from those of the steps before.

Two guesses are kept for every stage: one on a line through the last two known stages, which is
better after a disturbance, and one on a parabola through the same stage of the last three steps,
which is better in smooth motion. The one that was nearer in the last step is used in the next. Only
equal steps are remembered, and no times, so the same motion has the same bits whenever it starts.
"""

from soft_sim_ros.core.backend.jit import kernel

from .problem import KNOWN, NEWEST, SECOND, SIZE, THIRD

LINE, PARABOLA = 0, 1


@kernel
def predict(work, i, h, share):
    """Set work.a, the guess of stage i of a step of h in s; leave it where nothing is known.

    share: how far the stage lies beyond the last known stage, over the distance of the last two
    known ones. For the first stage these are the first and the last stage of the step before (one
    stage: the last two steps), for later ones the last stage of the step before and the first of
    this one; ``share`` then counts from the former.
    """
    known = 0 if work.restart[0] != 0 or work.age[SIZE] != h else int(work.age[KNOWN])
    stages, n = work.stage_a.shape
    memory, now = work.memory, work.stage_a
    line, parabola = work.guesses[LINE], work.guesses[PARABOLA]
    if known == 0 or (stages == 1 and known == 1):
        for c in range(n):
            line[c] = parabola[c] = work.a[c]
        return
    last = stages - 1
    for c in range(n):
        if i == 0:
            old = memory[NEWEST, 0, c] if stages > 1 else memory[SECOND, 0, c]
            line[c] = memory[NEWEST, last, c] + share * (memory[NEWEST, last, c] - old)
        else:
            line[c] = memory[NEWEST, last, c] + share * (now[0, c] - memory[NEWEST, last, c])
    if known < 3:
        for c in range(n):
            parabola[c] = line[c]
    elif i == 0:
        for c in range(n):
            parabola[c] = 3.0 * (memory[NEWEST, 0, c] - memory[SECOND, 0, c]) + memory[THIRD, 0, c]
    else:
        # the difference to the first stage varies smoothly from step to step
        for c in range(n):
            d0 = memory[NEWEST, i, c] - memory[NEWEST, 0, c]
            d1 = memory[SECOND, i, c] - memory[SECOND, 0, c]
            d2 = memory[THIRD, i, c] - memory[THIRD, 0, c]
            parabola[c] = now[0, c] + 3.0 * (d0 - d1) + d2
    best = line if work.better[i] == LINE else parabola
    for c in range(n):
        work.a[c] = best[c]


@kernel
def judge(model, work, i):
    """Note which guess of stage i came nearer to its solution work.a."""
    line, parabola = 0.0, 0.0
    for c in range(len(work.a)):
        weight = model.weight[c]
        line = max(line, abs(work.a[c] - work.guesses[LINE, c]) * weight)
        parabola = max(parabola, abs(work.a[c] - work.guesses[PARABOLA, c]) * weight)
    work.better[i] = PARABOLA if parabola < line else LINE


@kernel
def remember(work, h):
    """Keep the stages of a step of h in s that has succeeded."""
    if work.restart[0] != 0 or work.age[SIZE] != h:
        work.age[KNOWN] = 0.0
    stages, n = work.stage_a.shape
    for i in range(stages):
        for c in range(n):
            work.memory[THIRD, i, c] = work.memory[SECOND, i, c]
            work.memory[SECOND, i, c] = work.memory[NEWEST, i, c]
            work.memory[NEWEST, i, c] = work.stage_a[i, c]
    work.age[KNOWN] = min(3.0, work.age[KNOWN] + 1.0)
    work.age[SIZE] = h
    work.restart[0] = 0
