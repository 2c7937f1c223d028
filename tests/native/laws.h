/* What must hold of the outputs of any of the models, whatever was done to it. */
#ifndef LAWS_H
#define LAWS_H

#include "subject.h"

/* hold outputs at a communication point against the laws; `before` is what was known at the last, NULL at the start */
void laws_hold(subject *s, const knowledge *before);

#endif
