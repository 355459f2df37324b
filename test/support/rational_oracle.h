/* test/support/rational_oracle.h - whether two triangles intersect, by rational arithmetic: the
 * first triangle is clipped by the half-spaces whose intersection is the second one, and the
 * corners of what is left are looked at. Nothing of it is shared with the judge. */
#ifndef TULLE_TEST_RATIONAL_ORACLE_H
#define TULLE_TEST_RATIONAL_ORACLE_H

#include "check/triangle_pair.h"

bool oracle_triangles_intersect(const check_triangle *a, const check_triangle *b, bool can_share);

#endif
