/* Written by make_elementary.py, which says what these numbers are. */
/* clang-format off */

/* log 2 in two parts, of which the first has 32 bits */
static const double OF_TWO_LOG_2_HIGH = 0x1.62e42ff000000p-1;
static const double OF_TWO_LOG_2_LOW = -0x1.718432a1b0e26p-35;

/* (x coth(x/2) - 2)/x^2 as a polynomial in x^2, |x| <= log(2)/2 */
static const double OF_TWO_EXP_SERIES[5] = {
    0x1.555555555552dp-3, -0x1.6c16c16bd9fb9p-9, 0x1.1566aac07a21dp-14, -0x1.bbd3aa9751fc9p-20, 0x1.6348e79e19ea6p-25,
};

/* The same, |x| <= 0.1 */
static const double OF_TWO_EXP_SMALL = 0x1.999999999999ap-4;

static const double OF_TWO_EXP_SMALL_SERIES[3] = {
    0x1.5555555551b14p-3, -0x1.6c16bf915bafcp-9, 0x1.154249fa04e13p-14,
};

/* (2 artanh(s) - 2 s)/s^3 as a polynomial in s^2, |s| <= (sqrt(2) - 1)/(sqrt(2) + 1) */
static const double OF_TWO_LOG_SERIES[7] = {
    0x1.5555555555592p-1, 0x1.999999997fd32p-2, 0x1.24924941f901bp-2, 0x1.c71c520292835p-3, 0x1.74664061c3d5cp-3,
    0x1.39a192a90afccp-3, 0x1.2f070aeed304ep-3,
};
