/* A driller that holds the weight on bit by the feed. Follows models/controllers/autodriller.py, which explains it. */
#include "ds_limit.h"

enum { WEIGHT, DEPTH, SUM, FEED, ENGAGED, LIMITED, DS_MEMORY };

#include "ds_law.h"

ds_result ds_model_check(const double value[], ds_journal *journal)
{
    (void)value;
    (void)journal;
    return DS_OK;
}

static double rate_at(const double value[], double weight, double bit_speed)
{
    if (weight <= value[DS_W_0] || bit_speed <= 0.0) {
        return 0.0;
    }
    return value[DS_a] * (weight - value[DS_W_0]) * bit_speed;
}

static void begin(double memory[], const double value[])
{
    const double feed = rate_at(value, value[DS_WOB_initial], value[DS_bit_speed]);
    memory[WEIGHT] = value[DS_WOB_initial];
    memory[DEPTH] = 0.0;
    memory[LIMITED] = feed > value[DS_feed_max];
    memory[FEED] = memory[LIMITED] != 0.0 ? value[DS_feed_max] : feed;
    memory[SUM] = memory[FEED];
    memory[ENGAGED] = value[DS_enabled] != 0.0;
}

static void begin_change(const double value[], const double seed[], double drift[])
{
    (void)value;
    drift[WEIGHT] = seed[DS_WOB_initial];
}

static ds_result advance(double memory[], const double value[], const double slope[], double elapsed,
                         ds_journal *journal)
{
    const int enabled = value[DS_enabled] != 0.0;
    const double bit_speed = value[DS_bit_speed] + 0.5 * slope[DS_bit_speed] * elapsed;
    const double before = memory[WEIGHT];
    const double error = (value[DS_WOB_ref] + 0.5 * slope[DS_WOB_ref] * elapsed) - before;
    const double least = value[DS_feed_min];
    const double most = value[DS_feed_max];
    if (ds_require_short(elapsed, journal) != DS_OK) {
        return DS_DISCARD;
    }
    if (!enabled || memory[ENGAGED] == 0.0) {
        memory[SUM] = memory[FEED] - value[DS_K_p] * error;
    }
    const double wanted = enabled ? value[DS_K_p] * error + memory[SUM] : memory[FEED];
    const double feed = ds_limited(wanted, least, most);
    if (enabled && !((wanted > most && error > 0.0) || (wanted < least && error < 0.0))) {
        memory[SUM] = memory[SUM] + value[DS_K_p] / value[DS_T_i] * elapsed * error;
    }
    double share = 0.0;
    if (before > value[DS_W_0] && bit_speed > 0.0) {
        share = 0.5 * elapsed * value[DS_k] * value[DS_a] * bit_speed;
    }
    double above = before - value[DS_W_0];
    above = (above * (1.0 - share) + elapsed * value[DS_k] * feed) / (1.0 + share);
    const double weight = above + value[DS_W_0];
    memory[WEIGHT] = ds_limited(weight, 0.0, value[DS_WOB_max]);
    const double drilled = rate_at(value, before, bit_speed) + rate_at(value, memory[WEIGHT], bit_speed);
    memory[DEPTH] = memory[DEPTH] + 0.5 * elapsed * drilled;
    memory[FEED] = feed;
    memory[ENGAGED] = enabled;
    memory[LIMITED] = feed != wanted || memory[WEIGHT] != weight;
    return DS_OK;
}

static void move(const double memory[], const double value[], double drift[])
{
    const double rate = rate_at(value, memory[WEIGHT], value[DS_bit_speed]);
    const double change = value[DS_k] * (memory[FEED] - rate);
    const int held = (memory[WEIGHT] <= 0.0 && change < 0.0) || (memory[WEIGHT] >= value[DS_WOB_max] && change > 0.0);
    drift[WEIGHT] = held ? 0.0 : change;
    drift[DEPTH] = rate;
}

static void answer(const double memory[], double value[])
{
    value[DS_WOB] = memory[WEIGHT];
    value[DS_rop] = rate_at(value, memory[WEIGHT], value[DS_bit_speed]);
    value[DS_depth] = memory[DEPTH];
    value[DS_limit_active] = memory[LIMITED];
}

static void differentiate(const double memory[], const double value[], const double drift[], const double seed[],
                          double change[])
{
    const double above = memory[WEIGHT] - value[DS_W_0];
    change[DS_WOB] = drift[WEIGHT];
    change[DS_depth] = drift[DEPTH];
    if (above > 0.0 && value[DS_bit_speed] > 0.0) {
        change[DS_rop] = seed[DS_a] * above * value[DS_bit_speed] + value[DS_a] * above * seed[DS_bit_speed]
                         + value[DS_a] * (drift[WEIGHT] - seed[DS_W_0]) * value[DS_bit_speed];
    }
}

static void tell_changes(const double before[], const double value[], double time, ds_journal *journal)
{
    if (value[DS_limit_active] != before[DS_limit_active]) {
        journal->event(journal->owner, time, value[DS_limit_active] != 0.0 ? "feed or weight is held at its limit"
                                                                           : "feed and weight are off their limits again");
    }
}
