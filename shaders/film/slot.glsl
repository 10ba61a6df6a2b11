// Writes a slot: the block's sums at one pixel. Layout and encoders come from src/film/slot.rs.
void slot_write(uint slot, Spectrum sum, Tally t) {
    uvec2 ledger = uvec2(0u);
    ledger = ledger_count(ledger, LEDGER_NAN, t.nan);
    ledger = ledger_count(ledger, LEDGER_INF, t.infinite);
    ledger = ledger_count(ledger, LEDGER_NEGATIVE, t.negative);
    ledger = ledger_count(ledger, LEDGER_DISAGREE, t.disagree);
    ledger = ledger_count(ledger, LEDGER_DEPTH, t.depth);
    ledger = ledger_count(ledger, LEDGER_CUT, t.cut);
#if HAS_ALPHA || MEDIA_STACK
    ledger = ledger_count(ledger, LEDGER_ALPHA_OVERFLOW, t.alpha_overflow);
#endif
#if MEDIA_STACK
    ledger = ledger_count(ledger, LEDGER_MEDIA_OVERFLOW, t.media_overflow);
#endif
    SlotRecord r = SlotRecord(sum, t.rays, ledger.x, ledger.y, t.lost_energy, t.first_bad);
    uint row = slot * (SLOT_ROWS + AOV_ROWS);
#if AOVS
    aov_write(t.aovs, row + SLOT_ROWS);
#endif
    slots.rows[row] = SlotRecord_row0(r);
    slots.rows[row + 1u] = SlotRecord_row1(r);
}
